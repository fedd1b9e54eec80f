# SPDX-License-Identifier: GPL-3.0-or-later
"""Follow in a window: no act is begun, and the mesh follows whatever moves its handles."""

from collections.abc import Generator
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import rna_xml
import scenes
from harness import Steps, Ui
from mathutils import Vector

LIGHT_THEME = Path(bpy.utils.system_resource("SCRIPTS")) / "presets" / "interface_theme" / "Blender_Light.xml"
NEAR = 1e-5
SAME = 5e-3  # of a bar 4 long: what two ways to one pose may differ by, at the accuracy set here


def bar(name: str = "Bar") -> bpy.types.Object:
    return bpy.data.objects[name]


def is_settled(ui: Ui, name: str = "Bar") -> bool:
    run = ui.follow.run_of(bar(name))
    return run is not None and run.is_settled and not run.pause


def settle(ui: Ui, *names: str) -> Steps:
    yield
    for name in names or ("Bar",):
        yield from ui.until(lambda name=name: is_settled(ui, name), f"{name} settles")
    yield


def begin(ui: Ui) -> Steps:
    """The bar, its top on a handle, live, and followed at every evaluation however slow the machine is."""
    ui.change(ui.follow_run, "HEAVY_STEP_S", float("inf"))
    scenes.add_bar_with_handle(ui.api)
    bar().arap.accuracy = 1e-6
    bar().arap.max_iterations = 2000
    bar().arap.use_follow = True
    ui.select(bpy.data.objects["Top"])
    yield from settle(ui)
    bpy.ops.ed.undo_push(message="live")
    yield from ui.move_mouse_to_view()


def add_second_bar(ui: Ui) -> None:
    """A copy beside it, with a mesh and a handle of its own."""
    first = bar()
    second = bpy.data.objects.new("Second", first.data.copy())
    bpy.context.scene.collection.objects.link(second)
    if second.data.shape_keys is not None:
        second.shape_key_clear()
    second.location.x = 3.0
    bpy.context.view_layer.update()
    ui.api.add_pin(second, scenes.bottom(), name="Bottom")
    ui.api.add_handle(second, scenes.top(), name="Other")
    second.arap.accuracy, second.arap.max_iterations = 1e-6, 2000
    second.arap.use_follow = True


def animate(target: bpy.types.Object, *, reach: float) -> None:
    home = target.location.copy()
    for frame, shift, turn in ((1, 0.0, 0.0), (15, reach, 1.2), (30, 0.3 * reach, 0.2)):
        target.location = home + Vector((shift, 0.0, 0.0))
        target.rotation_euler.y = turn
        target.keyframe_insert("location", frame=frame)
        target.keyframe_insert("rotation_euler", frame=frame)


def assert_followed(ui: Ui, name: str = "Bar") -> None:
    """Top and bottom are where handle and pin want them."""
    obj = bar(name)
    shown = scenes.shown_positions(obj)
    rest = scenes.key_positions(obj, "Basis")
    motion = ui.handle_motion.handle_matrices(obj)[1]
    assert np.isfinite(shown).all()
    assert obj.arap.use_follow, obj.arap.follow_error
    top = rest[scenes.top()] @ motion[:3, :3].T + motion[:3, 3]
    np.testing.assert_allclose(shown[scenes.top()], top, atol=NEAR)
    np.testing.assert_allclose(shown[scenes.bottom()], rest[scenes.bottom()], atol=NEAR)


def add_nodes_that_take_the_places(obj: bpy.types.Object) -> bpy.types.Modifier:
    tree = bpy.data.node_groups.new("Nodes", "GeometryNodeTree")
    for side in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=side, socket_type="NodeSocketGeometry")
    place = tree.nodes.new("GeometryNodeSetPosition")
    combined = tree.nodes.new("ShaderNodeCombineXYZ")
    for start, end in (
        (tree.nodes.new("NodeGroupInput").outputs[0], place.inputs["Geometry"]),
        (place.outputs[0], tree.nodes.new("NodeGroupOutput").inputs[0]),
        (tree.nodes.new("GeometryNodeInputIndex").outputs[0], combined.inputs[0]),
        (combined.outputs[0], place.inputs["Position"]),
    ):
        tree.links.new(start, end)
    modifier = obj.modifiers.new("Nodes", "NODES")
    modifier.node_group = tree
    return modifier


def drag(ui: Ui, amount: str = "1") -> Steps:
    """G along x, confirmed."""
    yield from ui.key("G")
    yield from ui.key("X")
    yield from ui.text(amount)
    yield from ui.key("RET")


def test_follow_waits_while_modifiers_hide_the_pose(ui: Ui) -> Steps:
    """It looks when they change, says so in the tab, and goes on when the pose is seen again."""
    yield from begin(ui)
    yield from ui.open_tab()
    posed = scenes.key_positions(bar(), "ARAP")
    modifier = add_nodes_that_take_the_places(bar())
    reason = "Paused: A pose of 'Bar' would not be seen: modifier 'Nodes' takes the vertices from elsewhere"
    yield from ui.until(lambda: ui.follow.run_of(bar()).pause.startswith(reason), "it is seen to be hidden")
    yield from drag(ui)
    np.testing.assert_array_equal(scenes.key_positions(bar(), "ARAP"), posed)
    modifier.show_viewport = False
    yield from settle(ui)
    assert_followed(ui)
    assert np.abs(scenes.key_positions(bar(), "ARAP") - posed).max() > 0.5


def test_follow_follows_a_drag_and_undo_and_redo(ui: Ui) -> Steps:
    """G moves the mesh before it is confirmed; undo and redo are Blender's own and the mesh goes along."""
    yield from begin(ui)
    rest = scenes.key_positions(bar(), "Basis")
    yield from ui.open_tab()
    yield from ui.key("G")
    yield from ui.key("X")
    yield from ui.text("1")
    shown = scenes.shown_positions(bar())
    np.testing.assert_allclose(shown[scenes.top()], rest[scenes.top()] + [1.0, 0.0, 0.0], atol=NEAR)
    yield from ui.key("RET")
    yield from settle(ui)
    yield from ui.screenshot("followed")
    assert_followed(ui)
    posed = scenes.shown_positions(bar())
    yield from drag(ui)
    yield from settle(ui)
    for _ in range(3):  # two drags, and back and forth
        yield from ui.undo()
        yield from settle(ui)
        assert_followed(ui)
        np.testing.assert_allclose(scenes.shown_positions(bar()), posed, atol=SAME)
        yield from ui.redo()
        yield from settle(ui)
        assert_followed(ui)
        assert abs(bpy.data.objects["Top"].location.x - 2.0) < NEAR
    for _ in range(2):
        yield from ui.undo()
        yield from settle(ui)
    assert_followed(ui)
    np.testing.assert_allclose(scenes.shown_positions(bar()), rest, atol=SAME)


def test_follow_playback(ui: Ui) -> Steps:
    """The mesh follows in each frame that is played, and settles where it stops."""
    yield from begin(ui)
    animate(bpy.data.objects["Top"], reach=1.5)
    bpy.context.scene.frame_end = 30
    bpy.context.scene.frame_set(1)
    yield from settle(ui)
    played: list[int] = []

    def note(scene: bpy.types.Scene, _depsgraph: bpy.types.Depsgraph) -> None:
        played.append(scene.frame_current)

    bpy.app.handlers.frame_change_post.append(note)
    ui.call(bpy.ops.screen.animation_play, "EXEC_DEFAULT", True)
    for n_frames in (3, 6):
        yield from ui.until(lambda n=n_frames: len(set(played)) >= n, f"{n_frames} frames are played")
        assert_followed(ui)
        assert ui.window.screen.is_animation_playing
    yield from ui.screenshot("playing")
    ui.call(bpy.ops.screen.animation_play, "EXEC_DEFAULT", True)
    yield from settle(ui)
    bpy.app.handlers.frame_change_post.remove(note)
    assert_followed(ui)
    stopped = scenes.shown_positions(bar())
    for frame in (1, bpy.context.scene.frame_current):
        bpy.context.scene.frame_set(frame)
        yield from settle(ui)
    np.testing.assert_allclose(scenes.shown_positions(bar()), stopped, atol=SAME)


def test_follow_and_a_posing_act(ui: Ui) -> Steps:
    """Follow waits while the mesh is posed; once the act has ended it follows again."""
    yield from begin(ui)
    yield from drag(ui)
    yield from settle(ui)
    assert ui.call(bpy.ops.arap.pose) == {"RUNNING_MODAL"}
    yield from ui.until(lambda: ui.follow.run_of(bar()).pause == "Paused while it is posed", "Follow waits")
    yield from drag(ui)
    yield from ui.until(lambda: ui.running["Bar"].is_settled, "the act settles")
    yield from ui.key("ESC")
    yield from settle(ui)
    assert_followed(ui)
    assert abs(bpy.data.objects["Top"].location.x - 1.0) < NEAR
    yield from drag(ui)
    yield from settle(ui)
    assert_followed(ui)


def test_follow_frames_shown_alone_are_finished(ui: Ui) -> Steps:
    """A script's frame_set, and each frame of a viewport render, shows the end of the solve, also of a heavy mesh."""
    yield from begin(ui)
    animate(bpy.data.objects["Top"], reach=1.5)
    ui.change(ui.follow_run, "HEAVY_STEP_S", 0.0)
    ui.change(ui.tracker, "FOLLOW_TIME_LIMIT_S", 1e-9)
    scene = bpy.context.scene
    seen: dict[int, list[np.ndarray]] = {}

    def note(scene: bpy.types.Scene, _depsgraph: bpy.types.Depsgraph) -> None:
        seen.setdefault(scene.frame_current, []).append(scenes.key_positions(bar()))

    bpy.app.handlers.frame_change_post.append(note)
    for frame in (15, 30, 22):
        scene.frame_set(frame)
        assert ui.follow.run_of(bar()).is_settled
    scene.frame_start, scene.frame_end = 14, 16
    scene.render.filepath = f"{bpy.app.tempdir}frame_"
    scene.render.resolution_x = scene.render.resolution_y = 32
    ui.call(bpy.ops.render.opengl, "EXEC_DEFAULT", animation=True)
    bpy.app.handlers.frame_change_post.remove(note)
    for frame in (14, 15, 16):
        for shown in seen[frame]:
            np.testing.assert_allclose(shown, seen[frame][0], atol=SAME)
    bar().arap.use_follow = False
    for frame in (15, 30):
        scene.frame_set(frame)
        ui.api.solve(bar())
        np.testing.assert_allclose(seen[frame][0], scenes.key_positions(bar()), atol=SAME)


def test_follow_bind_is_shown_and_ends_on_esc(ui: Ui) -> Steps:
    """The bar is drawn over the view, in each theme and size. Esc switches Follow off, and nothing moves."""
    yield from begin(ui)
    shown = scenes.shown_positions(bar())
    texts = []
    draw = ui.waiting.draw_wait

    def noting_draw(context: bpy.types.Context, wait: Any) -> None:
        draw(context, wait)
        texts.append(wait.text)

    ui.change(ui.waiting, "draw_wait", noting_draw)
    bar().arap.overlay.show_strain = True  # its legend is near the bar
    assert not ui.can(bpy.ops.arap.preparing_cancel), "without a bind Esc is Blender's own"
    with ui.held_stage():
        ui.sessions.drop(bpy.data.objects["Bar"].session_uid)
        bpy.data.objects["Top"].location.x += 1.0
        yield from ui.until(lambda: bool(texts), "the bar is drawn")
        assert texts[0].startswith("Preparing Bar, ")
        yield from ui.screenshot("dark")
        ui.change(bpy.context.preferences.view, "ui_scale", 2.0)
        yield from ui.screenshot("dark_200")
        rna_xml.xml_file_run(bpy.context, str(LIGHT_THEME), (("preferences.themes[0]", "Theme"),))
        yield from ui.screenshot("light_200")
        bpy.context.preferences.view.ui_scale = 1.0
        yield from ui.screenshot("light")
        bpy.ops.preferences.reset_default_theme()
        yield from ui.key("ESC")
        yield from ui.until(lambda: not bar().arap.use_follow, "Follow is off")
        yield from ui.until_no_bar()
    np.testing.assert_array_equal(scenes.shown_positions(bar()), shown)
    assert not ui.can(bpy.ops.arap.preparing_cancel)
    bar().arap.use_follow = True
    yield from settle(ui)
    assert_followed(ui)


def test_follow_frame_that_must_bind_catches_up(ui: Ui) -> Steps:
    """The first step to another frame after a load does not wait for the bind, however long that takes."""
    yield from begin(ui)
    animate(bpy.data.objects["Top"], reach=1.5)
    ui.sessions.drop(bpy.data.objects["Bar"].session_uid)
    with ui.held_stage() as gate:
        bpy.context.scene.frame_set(15)
        assert ui.follow.run_of(bar()).is_binding
        yield from ui.until_held()
        gate.open()
    yield from settle(ui)
    caught_up = scenes.key_positions(bar())
    bpy.context.scene.frame_set(30)
    bpy.context.scene.frame_set(15)
    np.testing.assert_allclose(scenes.key_positions(bar()), caught_up, atol=SAME)


def test_follow_of_an_opened_file_binds_nothing_before_something_moves(ui: Ui) -> Steps:
    """Nor does drawing it, or a look at another frame without an animation."""
    yield from begin(ui)
    yield from drag(ui)
    yield from settle(ui)
    bar().shape_key_clear()
    path = f"{bpy.app.tempdir}live.blend"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    ui.call(bpy.ops.wm.open_mainfile, "EXEC_DEFAULT", filepath=path)
    yield
    yield from ui.open_tab()
    for frame in (2, 3):
        yield from ui.move_mouse_to_view()
        bpy.context.scene.frame_set(frame)
        yield
        assert (ui.session_of("Bar"), bar().data.shape_keys, bpy.data.is_dirty) == (None, None, False)
    assert is_settled(ui)
    ui.select(bpy.data.objects["Top"])
    yield from drag(ui)
    yield from settle(ui)
    assert_followed(ui)


def test_follow_stays_off_after_an_unrelated_undo(ui: Ui) -> Steps:
    """Follow has given up, the artist mends the cause and goes on by hand: undo takes back that step alone."""
    yield from begin(ui)
    yield from drag(ui)
    yield from settle(ui)
    bar().data.shape_keys.key_blocks["ARAP"].mute = True
    bpy.ops.ed.undo_push(message="muted")
    bpy.data.objects["Top"].location.x += 0.5
    yield from ui.until(lambda: not bar().arap.use_follow, "Follow is off")
    bar().data.shape_keys.key_blocks["ARAP"].mute = False
    bpy.ops.ed.undo_push(message="unmuted")
    posed = scenes.key_positions(bar())
    bar().location.y += 1.0
    bpy.ops.ed.undo_push(message="moved by hand")
    yield from ui.undo()
    for _ in range(3):
        yield
    assert abs(bar().location.y) < NEAR
    assert not bar().arap.use_follow
    assert bar().arap.follow_error
    np.testing.assert_array_equal(scenes.key_positions(bar()), posed)


def test_follow_makes_a_removed_key_anew_as_a_step_of_undo(ui: Ui) -> Steps:
    """Blender keeps a mesh that no step has changed: a key made between two steps would be one that is gone."""

    def has_key() -> bool:
        return ui.pose_key.find(bar()) is not None

    yield from begin(ui)
    yield from drag(ui)
    yield from settle(ui)
    posed = scenes.key_positions(bar())
    for _ in range(2):
        bar().shape_key_clear()
        bpy.ops.ed.undo_push(message="keys removed")
        yield
        bpy.data.objects["Top"].location.x += 0.5
        bpy.ops.ed.undo_push(message="typed")  # as the sidebar does, before anything is evaluated
        yield from ui.until(has_key, "the key is made anew")
        yield from settle(ui)
        yield from ui.undo()
        for _ in range(5):
            yield
        assert not has_key()
        yield from ui.redo()
        assert has_key()
        for _ in range(3):
            yield from ui.undo()
        yield from settle(ui)
        np.testing.assert_allclose(scenes.key_positions(bar()), posed, atol=NEAR)


def make_cage(ui: Ui) -> Generator[None, None, bpy.types.Object]:
    """By the button; returns the cage, which is the active object now."""
    assert ui.call(bpy.ops.arap.cage_make, "INVOKE_DEFAULT", True) == {"RUNNING_MODAL"}
    yield from ui.until(lambda: "Cage" in bpy.context.object.name, "the cage is made")
    return bpy.context.object


def move_selected(ui: Ui, axis: str, amount: str) -> Steps:
    """G along an axis, confirmed."""
    ui.press("G")
    ui.press(axis)
    for letter in amount:
        ui.press_letter(letter)
    yield
    ui.press("RET")
    yield


def test_making_a_cage_is_shown_and_esc_ends_it(ui: Ui) -> Steps:
    """A large mesh takes seconds: a bar shows how far it is. Esc makes none."""
    scenes.add_bar()
    yield from ui.move_mouse_to_view()
    objects = list(bpy.data.objects)
    with ui.held_stage():
        assert ui.call(bpy.ops.arap.cage_make, "INVOKE_DEFAULT", True) == {"RUNNING_MODAL"}
        yield from ui.until_held()
        yield from ui.until_bar("Make Cage: around Bar, ")
        yield from ui.screenshot("cage_is_made")
        yield from ui.key("ESC")
        yield from ui.until_no_bar()
    assert list(bpy.data.objects) == objects
    assert not bar().modifiers
