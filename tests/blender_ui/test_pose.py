# SPDX-License-Identifier: GPL-3.0-or-later
"""The posing act, as an artist does it: with keys, in a window."""

from collections.abc import Generator

import bmesh
import bpy
import numpy as np
import scenes
from harness import Steps, Ui
from mathutils import Matrix, Vector

NEAR = 1e-5


def begin(ui: Ui, name: str = "Bar") -> Steps:
    """Starts the act and waits until it follows."""
    yield from ui.move_mouse_to_view()
    assert ui.call(bpy.ops.arap.pose) == {"RUNNING_MODAL"}
    yield from ui.until(lambda: name in ui.running and ui.running[name].is_settled, "the act has bound and settled")


def drag(ui: Ui, key: str = "G", axis: str = "X", amount: str = "1") -> Steps:
    """G, R or S along an axis, by a number, confirmed; waits until the mesh has settled."""
    ui.press(key)
    ui.press(axis)
    for letter in amount:
        ui.press_letter(letter)
    ui.press("RET")
    yield
    yield from settle(ui)


def add_bar(ui: Ui) -> np.ndarray:
    """The bar with a handle, which is selected, as a step of undo; returns its rest shape."""
    scenes.add_bar_with_handle(ui.api)
    ui.select(handle())
    bpy.ops.ed.undo_push(message="scene")
    return scenes.key_positions(bar())


def begin_moved(ui: Ui) -> Generator[None, None, np.ndarray]:
    """The bar in the act, its handle moved by one; returns its rest shape."""
    rest = add_bar(ui)
    yield from begin(ui)
    yield from drag(ui)
    return rest


def handle(name: str = "Top") -> bpy.types.Object:
    return bpy.data.objects[name]


def bar() -> bpy.types.Object:
    return bpy.data.objects["Bar"]


def key_names() -> list[str]:
    keys = bar().data.shape_keys
    return [key.name for key in keys.key_blocks] if keys else []


def settle(ui: Ui) -> Steps:
    yield
    yield from ui.until(lambda: "Bar" not in ui.running or ui.running["Bar"].is_settled, "the mesh settles")


def assert_followed(rest: np.ndarray, shift: tuple[float, float, float]) -> None:
    """The top has gone with its handle, the bottom has stayed, and what is between is in between."""
    shown = scenes.shown_positions(bar())
    np.testing.assert_allclose(shown[scenes.top()], rest[scenes.top()] + shift, atol=NEAR)
    np.testing.assert_allclose(shown[scenes.bottom()], rest[scenes.bottom()], atol=NEAR)
    middle = slice(4 * (scenes.N_RINGS // 2), 4 * (scenes.N_RINGS // 2) + 4)
    moved = np.linalg.norm(shown[middle] - rest[middle], axis=1)
    assert (moved > 0.1 * np.linalg.norm(shift)).all(), f"the middle of the bar did not follow: {moved}"


def assert_at_rest(rest: np.ndarray) -> None:
    np.testing.assert_allclose(scenes.shown_positions(bar()), rest, atol=NEAR)


def select_vertices(obj: bpy.types.Object, vertices: list[int]) -> None:
    mesh = bmesh.from_edit_mesh(obj.data)
    mesh.verts.ensure_lookup_table()
    for vertex in mesh.verts:
        vertex.select_set(False)
    for i in vertices:
        mesh.verts[i].select_set(True)
    mesh.select_flush(False)
    bmesh.update_edit_mesh(obj.data)


def test_handles_pose_enter_undo_redo(ui: Ui) -> Steps:
    """The whole way: pin and handle from selected vertices, Pose, G, Enter; undo takes all of the act back at once."""
    scenes.add_bar()
    rest = scenes.key_positions(bar())
    bpy.ops.ed.undo_push(message="scene")
    yield from ui.move_mouse_to_view()
    yield from ui.key("TAB")
    select_vertices(bar(), scenes.bottom())
    ui.call(bpy.ops.arap.pin_add)
    yield
    select_vertices(bar(), scenes.top())
    ui.call(bpy.ops.arap.handle_add, "EXEC_DEFAULT", True, name="Top")
    yield from ui.screenshot("handle_added")
    assert bar().mode == "EDIT"
    bar().arap.use_follow = False  # or it makes the key before the act does
    assert (handle().location - Vector(rest[scenes.top()].mean(axis=0))).length < NEAR
    yield from ui.key("TAB")
    ui.select(handle())
    yield from begin(ui)
    yield from ui.key("G")
    yield from ui.key("X")
    yield from ui.text("1")
    assert_followed(rest, (1.0, 0.0, 0.0))  # live, before G is confirmed
    yield from ui.key("RET")
    yield from drag(ui, axis="Z")
    yield from ui.screenshot("following")
    yield from ui.key("RET")
    yield from ui.until_free()
    assert_followed(rest, (1.0, 0.0, 1.0))
    assert bar().data.shape_keys.key_blocks["ARAP"].value == 1.0
    posed = scenes.key_positions(bar())
    assert np.abs(posed - rest).max() > 1.0, "the pose is in the shape key"

    yield from ui.undo()
    assert_at_rest(rest)
    assert abs(handle().location.x) < NEAR
    assert bar().data.shape_keys is None, "the keys that the act made are gone"
    yield from ui.redo()
    np.testing.assert_allclose(scenes.key_positions(bar()), posed, atol=NEAR)
    assert abs(handle().location.x - 1.0) < NEAR
    assert bar().arap.interaction_number == 0


def test_enter_and_esc_over_another_editor_are_its_own(ui: Ui) -> Steps:
    add_bar(ui)
    yield from begin(ui)
    for area in ui.window.screen.areas:
        if area.type != "VIEW_3D":
            yield from ui.move_mouse(area.x + area.width // 2, area.y + area.height // 2)
            for key in ("RET", "ESC"):
                yield from ui.key(key)
                assert "Bar" in ui.running, f"{key} over {area.type}"
    yield from ui.open_tab()
    sidebar = ui.region("UI")
    yield from ui.move_mouse(sidebar.x + sidebar.width // 3, sidebar.y + 10)
    yield from ui.key("RET")
    yield from ui.until_free()


def test_esc_restores_exactly(ui: Ui) -> Steps:
    """Esc brings back key values, slider and the handles' transforms, to the last bit."""
    scenes.add_bar_with_handle(ui.api)
    handle().rotation_mode = "QUATERNION"
    handle().location.x = 0.5
    ui.api.solve(bar())
    bar().data.shape_keys.key_blocks["ARAP"].value = 0.25
    yield
    key_before = scenes.key_positions(bar())
    channels_before = [*handle().location, *handle().rotation_quaternion, *handle().scale]
    ui.select(handle())
    yield from begin(ui)
    yield from drag(ui, "R", "Y", "45")
    yield from drag(ui, "S", "Z", "2")
    assert np.abs(scenes.key_positions(bar()) - key_before).max() > 0.1
    yield from ui.key("G")  # an Esc within G is G's own
    yield from ui.key("X")
    yield from ui.key("ESC")
    assert "Bar" in ui.running
    yield from ui.key("ESC")
    yield from ui.until_free()
    np.testing.assert_array_equal(scenes.key_positions(bar()), key_before)
    assert bar().data.shape_keys.key_blocks["ARAP"].value == 0.25
    assert [*handle().location, *handle().rotation_quaternion, *handle().scale] == channels_before
    yield from ui.screenshot("restored")


def test_esc_leaves_no_key_behind(ui: Ui) -> Steps:
    """A mesh without shape keys has none after Esc, and an undo does not bring the cancelled pose back."""
    rest = yield from begin_moved(ui)
    yield from ui.key("ESC")
    assert bar().data.shape_keys is None
    yield from ui.undo()
    assert_at_rest(rest)
    assert abs(handle().location.x) < NEAR


def test_undo_within(ui: Ui) -> Steps:
    """Ctrl Z takes one step back, other work or the move of a handle, which the mesh follows; the act goes on."""
    rest = add_bar(ui)
    yield from begin(ui)
    ui.call(bpy.ops.object.duplicate, "EXEC_DEFAULT", True)
    yield from settle(ui)
    assert "Top.001" in bpy.data.objects
    yield from ui.undo()
    yield from settle(ui)
    assert "Top.001" not in bpy.data.objects
    assert "Bar" in ui.running
    for _ in range(2):
        yield from drag(ui)
    assert_followed(rest, (2.0, 0.0, 0.0))
    yield from ui.undo()
    yield from settle(ui)
    assert "Bar" in ui.running
    assert_followed(rest, (1.0, 0.0, 0.0))
    yield from ui.undo()
    yield from settle(ui)
    assert "Bar" in ui.running
    assert_at_rest(rest)
    yield from ui.redo()
    yield from settle(ui)
    assert_followed(rest, (1.0, 0.0, 0.0))
    yield from ui.key("RET")
    assert_followed(rest, (1.0, 0.0, 0.0))


def test_undo_past_the_beginning(ui: Ui) -> Steps:
    """One undo more than there are moves leaves the act, as it leaves Edit Mode, and takes nothing else back."""

    def undo_of_the_menu() -> Steps:
        ui.call(bpy.ops.ed.undo, "EXEC_DEFAULT")
        yield

    bpy.ops.ed.undo_push(message="before")
    bpy.context.scene["step"] = 1
    rest = add_bar(ui)
    for undo in (undo_of_the_menu, ui.undo):
        yield from begin(ui)
        assert not bpy.ops.arap.pose.poll(), "one act at a time on an object"
        yield from drag(ui)
        for _ in range(2):
            yield from undo()
        yield from ui.until_free()
        assert_at_rest(rest)
        assert bar().data.shape_keys is None
        assert abs(handle().location.x) < NEAR
        assert bpy.context.scene["step"] == 1
    for _ in range(2):  # nothing is lost: redo has the moves
        yield from ui.redo()
    assert key_names() == ["Basis", "ARAP"]
    assert abs(handle().location.x - 1.0) < NEAR
    yield from begin(ui)
    yield from ui.key("RET")
    assert_followed(rest, (1.0, 0.0, 0.0))


def test_renamed_key_within(ui: Ui) -> Steps:
    """The act goes on with a key that is renamed in Blender's list, also over undo and redo."""
    rest = yield from begin_moved(ui)
    bar().data.shape_keys.key_blocks["ARAP"].name = "Bent"
    bpy.ops.ed.undo_push(message="Rename")
    yield from drag(ui)
    assert key_names() == ["Basis", "Bent"]
    # Back to the renaming, which the add-on saw only after its step; to the move before it; and forward again.
    for is_redo, name in ((False, "Bent"), (False, "ARAP"), (True, "Bent"), (True, "Bent")):
        yield from ui.key("Z", ctrl=True, shift=is_redo)
        yield from settle(ui)
        assert "Bar" in ui.running
        assert key_names() == ["Basis", name]
        assert bar().arap.key_name == name
    assert_followed(rest, (2.0, 0.0, 0.0))
    yield from ui.key("ESC")
    yield from ui.until_free()
    assert bar().data.shape_keys is None
    assert bar().arap.key_name == ""
    assert_at_rest(rest)


def test_edit_mode_within(ui: Ui) -> Steps:
    """Tab ends the act; the pose stays, and Edit Mode does not lose it."""
    rest = yield from begin_moved(ui)
    ui.select(bar())
    yield from ui.key("TAB")
    assert bar().mode == "EDIT"
    yield from ui.until_free()
    yield from ui.key("TAB")
    assert_followed(rest, (1.0, 0.0, 0.0))


def test_esc_while_binding(ui: Ui) -> Steps:
    """A bind that takes long leaves Blender alive, tells how far it is, and Esc drops it."""
    obj = scenes.add_held_grid(ui.api)
    for number in (1, 2):
        bpy.context.scene["step"] = number
        bpy.ops.ed.undo_push(message="step")
    yield from ui.move_mouse_to_view()
    with ui.held_stage():
        ui.call(bpy.ops.arap.pose)
        act = ui.running["Grid"]
        yield from ui.until_held()
        yield from ui.until(lambda: act.bind_fraction > 0.0, "the bind tells how far it is")
        yield from ui.until_bar("Preparing Grid, ")
        yield from ui.screenshot("binding")
        yield from ui.key("ESC")
        yield from ui.until_free()
        assert obj.data.shape_keys is None
        yield from ui.until_no_bar()
    yield from ui.undo()  # passes over the act, and over nothing else
    yield from ui.until(
        lambda: bpy.data.objects["Grid"].arap.interaction_number == 0, "the undo has passed over the act"
    )
    assert bpy.context.scene["step"] == 2
    yield from ui.undo()
    assert bpy.context.scene["step"] == 1


def test_other_work_within(ui: Ui) -> Steps:
    """Other work within the act (a copy of the mesh, saving) stays with it; later undo steps are not swallowed."""
    rest = yield from begin_moved(ui)
    ui.select(bar())
    ui.call(bpy.ops.object.duplicate, "EXEC_DEFAULT", True)
    ui.select(handle())
    path = f"{bpy.app.tempdir}within.blend"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    yield from settle(ui)
    yield from ui.key("RET")
    assert "Bar.001" in bpy.data.objects
    yield from drag(ui)
    yield from ui.undo()
    assert "Bar.001" in bpy.data.objects
    assert_followed(rest, (1.0, 0.0, 0.0))
    assert abs(handle().location.x - 1.0) < NEAR
    yield from ui.undo()
    assert "Bar.001" not in bpy.data.objects
    assert_at_rest(rest)

    ui.call(bpy.ops.wm.open_mainfile, "EXEC_DEFAULT", filepath=path)
    yield from ui.until_free()
    bpy.context.scene.cursor.location.x = 1.0
    with ui.override():
        bpy.ops.ed.undo_push(message="cursor")
    ui.call(bpy.ops.ed.undo, "EXEC_DEFAULT")
    yield
    yield
    yield from begin(ui)
    yield from ui.key("RET")


def test_bone_as_handle(ui: Ui) -> Steps:
    """A bone moved in Pose Mode moves the mesh, and Esc puts it back."""
    scenes.add_bar()
    rest = scenes.key_positions(bar())
    armature = scenes.add_bone()
    ui.api.add_pin(bar(), scenes.bottom())
    ui.select(bar(), armature)
    bpy.ops.object.mode_set(mode="POSE")
    ui.call(bpy.ops.arap.handle_add, "EXEC_DEFAULT", True, radius=0.8)
    assert bar().arap.handles[0].bone == "Bone"
    yield from begin(ui)
    yield from drag(ui)
    assert_followed(rest, (1.0, 0.0, 0.0))
    yield from ui.screenshot("pose_mode")
    yield from drag(ui, "R", "Z", "90")
    yield from ui.key("ESC")
    assert_at_rest(rest)
    assert armature.pose.bones["Bone"].matrix_basis == Matrix()


def test_render_within(ui: Ui) -> Steps:
    """A render while posing neither crashes nor ends the act."""
    rest = add_bar(ui)
    scene = bpy.context.scene
    scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(scene.camera)
    scene.render.engine = "BLENDER_WORKBENCH"
    scene.render.resolution_x = scene.render.resolution_y = 64
    scene.frame_end = 3
    scene.render.filepath = f"{bpy.app.tempdir}frame"
    ui.change(bpy.context.preferences.view, "render_display_type", "NONE")
    yield from begin(ui)
    ui.call(bpy.ops.render.render, "INVOKE_DEFAULT", True, animation=True)
    yield from ui.until(lambda: not bpy.app.is_job_running("RENDER"), "the render is done")
    yield
    assert "Bar" in ui.running
    yield from drag(ui)
    assert_followed(rest, (1.0, 0.0, 0.0))
    yield from ui.key("RET")
