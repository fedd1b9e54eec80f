# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking from the dialogs, with progress and Esc."""

import bpy
import numpy as np
import scenes
from harness import Steps, Ui
from test_pose import NEAR, bar, handle, key_names
from test_pull import tells_keys


def animate(ui: Ui, n_frames: int) -> None:
    """The top of the bar goes one unit along x."""
    scenes.add_bar_with_handle(ui.api)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 250  # the dialog proposes the frames of the keys
    handle().keyframe_insert("location", frame=1)
    handle().location.x += 1.0
    handle().keyframe_insert("location", frame=n_frames)
    scene.frame_set(3)


def test_bake_animation_dialog(ui: Ui) -> Steps:
    """The dialog tells the size, OK bakes, and every baked frame shows its pose; one undo takes it back."""
    animate(ui, 6)
    rest = scenes.key_positions(bar())
    bpy.ops.ed.undo_push(message="scene")
    yield from ui.move_mouse_to_view()
    ui.call(bpy.ops.arap.bake_animation)
    yield from ui.screenshot("dialog")
    yield from ui.key("RET")
    yield from ui.until(lambda: len(key_names()) > 6, "six frames are baked")
    assert bpy.context.scene.frame_current == 3
    names = key_names()
    bpy.context.scene.frame_set(6)
    shown = scenes.shown_positions(bar())
    np.testing.assert_allclose(shown[scenes.top()], rest[scenes.top()] + (1.0, 0.0, 0.0), atol=NEAR)
    np.testing.assert_allclose(shown, scenes.key_positions(bar(), names[-1]), atol=1e-6)
    bpy.context.scene.frame_set(3)
    yield from ui.screenshot("baked")
    yield from ui.undo()
    assert len(key_names()) <= 1


def test_bake_animation_esc(ui: Ui) -> Steps:
    """Esc in the dialog does nothing; Esc while it binds or bakes leaves everything as it was. Pull's keys give way."""
    animate(ui, 9)
    yield from ui.move_mouse_to_view()
    ui.call(bpy.ops.arap.pull_tool)
    assert tells_keys(ui)
    ui.call(bpy.ops.arap.bake_animation)
    yield
    yield from ui.key("ESC")
    yield
    assert key_names() == []
    for holding, is_baking in ((ui.held_stage(), False), (ui.held_shapes(), True)):
        ui.call(bpy.ops.arap.bake_animation)
        yield
        with holding:
            yield from ui.key("RET")
            yield from ui.until_held()
            assert bpy.context.scene.frame_current == 3, "the frames are read"
            yield from ui.until_bar("Bake: frame " if is_baking else "Bake: preparing the mesh, ")
            assert not tells_keys(ui)
            yield from ui.screenshot("baking" if is_baking else "binding")
            yield from ui.key("ESC")
            yield from ui.until_free()
        assert bpy.context.scene.frame_current == 3
        assert key_names() == []
    yield from ui.key("TAB")
    assert bar().mode == "EDIT", "keys are Blender's own again"


def test_bake_pose_dialog(ui: Ui) -> Steps:
    """The dialog takes a name; the key has the pose."""
    scenes.add_bar_with_handle(ui.api)
    handle().location.x += 1.0
    ui.api.solve(bar())
    yield from ui.move_mouse_to_view()
    ui.call(bpy.ops.arap.bake_pose)
    yield from ui.screenshot("dialog")
    yield from ui.key("RET")
    yield from ui.until(lambda: key_names() == ["Basis", "ARAP", "Pose"], "the pose is baked")
    np.testing.assert_array_equal(scenes.key_positions(bar(), "Pose"), scenes.key_positions(bar()))


def test_edit_again_leads_back_to_following(ui: Ui) -> Steps:
    """A bake while the mesh follows: no warning, one click goes on, and one undo takes that back."""
    animate(ui, 4)
    obj = bar()
    obj.arap.use_follow = True
    ui.select(obj)
    yield from ui.until(lambda: ui.follow.run_of(bar()).is_settled, "the mesh follows")
    ui.open_panels("ARAP_PT_bake")
    yield from ui.open_tab()
    ui.call(bpy.ops.arap.bake_animation, "EXEC_DEFAULT", True, frame_start=1, frame_end=4)
    bpy.ops.ed.undo_push(message="baked")
    yield from ui.until(lambda: ui.follow.run_of(bar()).pause != "", "Follow waits")
    assert (bar().arap.use_follow, bar().arap.follow_error) == (True, "")
    assert not ui.can(bpy.ops.arap.pose)
    yield from ui.screenshot("baked")
    ui.call(bpy.ops.arap.edit_again)
    assert len(key_names()) == 6
    bpy.context.window_manager.operators[-1].properties.is_removing = True
    assert ui.call(bpy.ops.ed.undo_redo, "EXEC_DEFAULT", True) == {"FINISHED"}
    assert key_names() == ["Basis", "ARAP"], "Adjust Last Operation removes the bake"
    handle().animation_data_clear()
    handle().location.x = 2.0
    yield from ui.until(lambda: ui.follow.run_of(bar()).is_settled, "the mesh follows again")
    np.testing.assert_allclose(scenes.shown_positions(bar())[scenes.top(), 0].mean(), 2.0, atol=NEAR)
    yield from ui.screenshot("again")
    yield from ui.undo()
    assert not ui.can(bpy.ops.arap.pose), "the bake is shown again"
