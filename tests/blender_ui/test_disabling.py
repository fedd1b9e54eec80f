# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on is disabled while it is at work: everything is as before, and enabled again it works again."""

import bpy
import numpy as np
import scenes
import test_follow
import test_pose
import test_pull
from harness import MODULE, Steps, Ui
from test_bake import animate
from test_pose import NEAR, bar, handle, key_names
from test_poses import add_poses


def disable() -> Steps:
    bpy.ops.preferences.addon_disable(module=MODULE)
    yield


def enable(ui: Ui) -> Steps:
    bpy.ops.preferences.addon_enable(module=MODULE)
    ui.find_modules()
    yield from ui.until_free()


def test_disabled_within_a_pose(ui: Ui) -> Steps:
    rest = test_pose.add_bar(ui)
    for _ in range(2):
        yield from test_pose.begin(ui)
        yield from test_pose.drag(ui)
        test_pose.assert_followed(rest, (1.0, 0.0, 0.0))
        yield from disable()
        test_pose.assert_at_rest(rest)
        assert abs(handle().location.x) < NEAR
        yield from enable(ui)


def test_follow_goes_on_after_it_was_disabled(ui: Ui) -> Steps:
    yield from test_follow.begin(ui)
    yield from disable()
    yield from enable(ui)
    yield from test_follow.settle(ui)
    yield from test_follow.drag(ui)
    yield from test_follow.settle(ui)
    test_follow.assert_followed(ui)


def test_disabled_while_a_mesh_that_follows_is_prepared(ui: Ui) -> Steps:
    """The bar goes, and Esc is Blender's own again."""

    def has_key() -> bool:
        keymap = bpy.context.window_manager.keyconfigs.addon.keymaps["3D View"]
        return any(item.idname == "arap.preparing_cancel" for item in keymap.keymap_items)

    yield from test_follow.begin(ui)
    for _ in range(2):
        with ui.held_stage():
            ui.sessions.drop(bpy.data.objects["Bar"].session_uid)
            handle().location.x += 1.0
            yield from ui.until_bar("Preparing Bar, ")
            assert has_key()
            yield from disable()
            assert not has_key()
        ui.view.tag_redraw()
        yield from enable(ui)
        yield from test_follow.settle(ui)
    test_follow.assert_followed(ui)


def test_disabled_within_a_blend(ui: Ui) -> Steps:
    bent = add_poses(ui)
    place = handle().matrix_world.copy()
    yield from ui.move_mouse_to_view()
    x, y = ui.mouse
    whole = round(300 * bpy.context.preferences.system.ui_scale)
    for _ in range(2):
        ui.call(bpy.ops.arap.poses_blend, "INVOKE_DEFAULT", True, pose="Straight")
        yield from ui.move_mouse(x + whole, y)
        yield from ui.until(lambda: np.abs(scenes.key_positions(bar()) - bent).max() > 0.3, "the mesh follows")
        yield from disable()
        np.testing.assert_allclose(np.array(handle().matrix_world), np.array(place), atol=NEAR)
        np.testing.assert_array_equal(scenes.key_positions(bar()), bent)
        yield from enable(ui)
        yield from ui.move_mouse(x, y)


def test_disabled_within_a_bake(ui: Ui) -> Steps:
    animate(ui, 9)
    yield from ui.move_mouse_to_view()
    for _ in range(2):
        with ui.held_shapes():
            ui.call(bpy.ops.arap.bake_animation, "EXEC_DEFAULT", True, frame_start=1, frame_end=9)
            yield from ui.until_held()
            yield from disable()
        assert bpy.context.scene.frame_current == 3
        assert key_names() == []
        yield from enable(ui)
    yield from ui.key("TAB")
    assert bar().mode == "EDIT", "keys are Blender's own again"


def test_disabled_within_a_pull(ui: Ui) -> Steps:
    yield from test_pull.begin(ui)
    rest = scenes.key_positions(test_pull.sheet())
    yield from test_pull.grab(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0))
    yield from disable()
    ui.event("LEFTMOUSE", "RELEASE")
    yield
    np.testing.assert_array_equal(scenes.key_positions(test_pull.sheet()), rest)
    yield from enable(ui)
    assert ui.call(bpy.ops.arap.pull_tool) == {"FINISHED"}
    yield from test_pull.pull(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0))
    assert np.abs(scenes.shown_positions(test_pull.sheet()) - rest).max() > 0.1
