# SPDX-License-Identifier: GPL-3.0-or-later
"""What happens to files, scenes, windows and names while a mesh is posed, pulled or live."""

from collections.abc import Generator
from contextlib import AbstractContextManager

import bpy
import numpy as np
import scenes
import test_follow
import test_pull
from harness import Steps, Ui
from test_follow import bar
from test_pose import NEAR, add_bar, assert_at_rest, assert_followed, begin, begin_moved, drag, handle, settle


def test_other_file_within(ui: Ui) -> Steps:
    """Another file, and File > New, end the act without a word, and what is in the new file can be posed."""
    rest = add_bar(ui)
    path = f"{bpy.app.tempdir}bar.blend"
    bpy.ops.wm.save_as_mainfile(filepath=path)
    yield from begin(ui)
    yield from drag(ui)
    ui.call(bpy.ops.wm.open_mainfile, "EXEC_DEFAULT", filepath=path)
    yield from ui.until_free()
    assert_at_rest(rest)
    assert bar().data.shape_keys is None
    yield from begin(ui)
    yield from drag(ui)
    ui.call(bpy.ops.wm.read_homefile, "EXEC_DEFAULT", use_factory_startup=True)
    yield from ui.until_free()
    yield
    yield from begin_moved(ui)
    assert_followed(rest, (1.0, 0.0, 0.0))
    yield from ui.key("RET")
    yield from ui.until_free()


def test_renamed_mesh_within(ui: Ui) -> Steps:
    """The act goes on under the new name."""
    yield from begin_moved(ui)
    pole = bar()
    posed = scenes.key_positions(pole)
    pole.name = "Pole"
    yield from drag(ui)
    yield from ui.until(lambda: ui.running["Pole"].is_settled, "the mesh settles")
    yield from ui.key("RET")
    yield
    top = scenes.key_positions(pole)[scenes.top()]
    np.testing.assert_allclose(top, posed[scenes.top()] + [1.0, 0.0, 0.0], atol=NEAR)


def test_other_scene_within(ui: Ui) -> Steps:
    """Another scene in the window ends the act, with the pose kept; Follow waits and goes on."""
    rest = yield from begin_moved(ui)
    first = bpy.context.scene
    other = bpy.data.scenes.new("Other scene")
    ui.window.scene = other
    yield from ui.until_free()
    handle().location.x += 1.0
    yield
    ui.window.scene = first
    yield
    assert_followed(rest, (1.0, 0.0, 0.0))
    bar().arap.use_follow = True
    yield from test_follow.settle(ui)
    test_follow.assert_followed(ui)
    ui.window.scene = other
    yield
    yield
    handle().location.x -= 1.0
    ui.window.scene = first
    yield from test_follow.settle(ui)
    test_follow.assert_followed(ui)


def test_two_windows(ui: Ui) -> Steps:
    """A second window on the same scene: the act goes on, both draw, and closing either is no accident."""
    rest = yield from begin_moved(ui)
    ui.call(bpy.ops.wm.window_new_main, "EXEC_DEFAULT", True)
    yield
    yield
    yield from ui.screenshot("both")
    assert len(bpy.context.window_manager.windows) == 2
    handle().location.x += 1.0
    yield from settle(ui)
    assert_followed(rest, (2.0, 0.0, 0.0))
    second = bpy.context.window_manager.windows[1]
    with ui.override(window=second):
        bpy.ops.wm.window_close()
    yield
    handle().location.x += 1.0
    yield from settle(ui)
    assert "Bar" in ui.running
    assert_followed(rest, (3.0, 0.0, 0.0))
    yield from ui.key("ESC")
    yield from ui.until_free()


def second_window(ui: Ui, scene: bpy.types.Scene) -> Generator[None, None, bpy.types.Window]:
    """A window of its own for a scene."""
    ui.call(bpy.ops.wm.window_new_main, "EXEC_DEFAULT", True)
    yield
    window = bpy.context.window_manager.windows[1]
    window.scene = scene
    yield
    return window


def in_view(ui: Ui, window: bpy.types.Window) -> AbstractContextManager[None]:
    """Where a button in the 3D view of the window would be."""
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    return ui.override(window=window, area=area, region=region)


def test_back_to_edit_mode_in_a_second_window(ui: Ui) -> Steps:
    """Of another scene, and of another view layer of the same scene, in which another object is active."""
    scenes.add_bar()
    first = bpy.context.scene
    for scene in (bpy.data.scenes.new("Other scene"), first):
        window = yield from second_window(ui, scene)
        if scene == first:
            window.view_layer = first.view_layers.new("Other layer")
        obj = bpy.data.objects.new("Second", bar().data.copy())
        scene.collection.objects.link(obj)
        yield
        ui.window.view_layer.objects.active = bar()
        window.view_layer.objects.active = obj
        with in_view(ui, window):
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.mesh.select_all(action="SELECT")
            assert bpy.ops.arap.pin_add("INVOKE_DEFAULT", True) == {"FINISHED"}
        yield from ui.until(lambda obj=obj: obj.mode == "EDIT", "the mesh is back in Edit Mode")
        assert len(obj.arap.pins) == 1
        with in_view(ui, window):
            bpy.ops.object.mode_set(mode="OBJECT")
            bpy.ops.wm.window_close()
        yield
        bpy.data.objects.remove(obj)


def test_undo_in_one_window_leaves_follow_of_the_other_scene_alone(ui: Ui) -> Steps:
    """Undo goes back in the whole file. Follow of the other scene moves nothing then, and what is off stays off."""
    yield from test_follow.begin(ui)
    other_scene = bpy.data.scenes.new("Other scene")
    window = yield from second_window(ui, other_scene)
    test_follow.add_second_bar(ui)
    other, others_handle = bpy.data.objects["Second"], bpy.data.objects["Other"]
    for obj in (other, others_handle):
        bpy.context.scene.collection.objects.unlink(obj)
        other_scene.collection.objects.link(obj)
    others_handle.location.x += 0.5
    yield from test_follow.settle(ui, "Bar", "Second")
    with in_view(ui, window):
        test_follow.assert_followed(ui, "Second")
    bpy.ops.ed.undo_push(message="two scenes")
    for use_follow in (True, False):
        if not use_follow:
            bar("Second").data.shape_keys.key_blocks["ARAP"].mute = True
            bpy.data.objects["Other"].location.x += 0.5
            yield from ui.until(lambda: not bar("Second").arap.use_follow, "Follow of the other scene has given up")
            bar("Second").data.shape_keys.key_blocks["ARAP"].mute = False
        posed = scenes.key_positions(bar("Second"))
        yield from ui.move_mouse_to_view()
        yield from test_follow.drag(ui)
        yield from test_follow.settle(ui)
        for step in (ui.undo, ui.redo, ui.undo):
            yield from step()
            yield from test_follow.settle(ui)
            test_follow.assert_followed(ui)
            np.testing.assert_array_equal(scenes.key_positions(bar("Second")), posed)
            assert (bar("Second").arap.use_follow, bool(bar("Second").arap.follow_error)) == (
                use_follow,
                not use_follow,
            )
            assert bpy.context.window_manager.windows[1].scene.name == "Other scene"


def test_renamed_mesh_within_a_pull(ui: Ui) -> Steps:
    """A mesh that gets another name under the mouse is pulled on."""
    yield from test_pull.begin(ui)
    yield from test_pull.grab(ui, (0.3, 0.0, 0.0), (0.5, 0.3, 0.0))
    sheet = test_pull.sheet()
    sheet.name = "Cloth"
    yield
    assert list(ui.running) == ["Cloth"]
    ui.event("LEFTMOUSE", "RELEASE")
    yield from ui.until_free()
    before = scenes.shown_positions(sheet)
    assert np.isfinite(before).all()
    yield from test_pull.pull(ui, (-0.5, -0.5, 0.0), (-0.5, -0.1, 0.0))
    assert np.abs(scenes.shown_positions(sheet) - before).max() > 0.2
