# SPDX-License-Identifier: GPL-3.0-or-later
"""The pose library in a window: its panel, its acts as steps of undo, with posing and Follow, progress and Esc."""

import tempfile
from pathlib import Path

import bpy
import numpy as np
import scenes
from harness import Steps, Ui
from test_bake import animate
from test_pose import NEAR, bar, begin, handle, key_names, settle


def add_poses(ui: Ui) -> np.ndarray:
    """The bar with the poses Straight and Bent; returns its shape in Bent, which is the pose shown."""
    scenes.add_bar_with_handle(ui.api)
    ui.api.store_pose(bar(), "Straight")
    handle().location.x += 1.0
    handle().rotation_euler.y = 0.8
    bpy.context.view_layer.update()
    ui.api.solve(bar())
    ui.api.store_pose(bar(), "Bent")
    bpy.ops.ed.undo_push(message="scene")
    return scenes.key_positions(bar())


def test_poses_panel(ui: Ui) -> Steps:
    """The panel without a pose, with some, and with their keys; each act is one step of undo."""
    ui.open_panels("ARAP_PT_poses")
    scenes.add_bar_with_handle(ui.api)
    yield from ui.open_tab()
    yield from ui.scroll_tab()
    yield from ui.screenshot("1_empty")
    bent = add_poses(ui)
    straight = scenes.key_positions(bar(), "Basis")
    yield from ui.screenshot("2_stored")
    yield from ui.move_mouse_to_view()
    ui.call(bpy.ops.arap.poses_apply, "EXEC_DEFAULT", True, pose="Straight")
    yield
    np.testing.assert_allclose(scenes.key_positions(bar()), straight, atol=NEAR)
    ui.call(bpy.ops.arap.poses_blend, "EXEC_DEFAULT", True, pose="Bent", factor=0.5)
    yield from ui.screenshot("3_blended")
    yield from ui.undo()
    np.testing.assert_allclose(scenes.key_positions(bar()), straight, atol=NEAR)
    yield from ui.undo()
    np.testing.assert_allclose(scenes.key_positions(bar()), bent, atol=NEAR)
    ui.call(bpy.ops.arap.poses_to_keys, "EXEC_DEFAULT", True)
    yield from ui.until(lambda: "Bent" in key_names(), "the poses are shape keys")
    yield from ui.screenshot("4_keys")
    np.testing.assert_allclose(scenes.key_positions(bar(), "Bent"), bent, atol=NEAR)
    yield from ui.undo()
    assert key_names() == ["Basis", "ARAP"]


def test_blend_is_adjusted_in_its_panel(ui: Ui) -> Steps:
    """Another factor, as the panel of the last act sets it, is as that factor at once."""
    add_poses(ui)
    ui.call(bpy.ops.arap.poses_apply, "EXEC_DEFAULT", True, pose="Straight")
    yield
    ui.call(bpy.ops.arap.poses_blend, "EXEC_DEFAULT", True, pose="Bent", factor=0.25)
    yield
    quarter = scenes.key_positions(bar())
    yield from ui.undo()
    yield from ui.move_mouse_to_view()
    ui.call(bpy.ops.arap.poses_blend, "EXEC_DEFAULT", True, pose="Bent", factor=0.75)
    yield
    yield from ui.key("F9")
    yield from ui.screenshot("panel")
    yield from ui.key("ESC")
    bpy.context.window_manager.operators[-1].factor = 0.25
    ui.call(bpy.ops.ed.undo_redo, "EXEC_DEFAULT", True)
    yield
    np.testing.assert_allclose(scenes.key_positions(bar()), quarter, atol=NEAR)


def test_poses_while_posing(ui: Ui) -> Steps:
    """A stored pose can be applied within a posing act: the mesh follows, and Esc takes it back with the rest."""
    bent = add_poses(ui)
    ui.select(handle())
    yield from begin(ui)
    ui.call(bpy.ops.arap.poses_apply, "EXEC_DEFAULT", True, pose="Straight")
    yield
    yield from settle(ui)
    straight = scenes.key_positions(bar(), "Basis")
    np.testing.assert_allclose(scenes.key_positions(bar()), straight, atol=10 * NEAR)
    yield from ui.screenshot("applied")
    yield from ui.key("ESC")
    yield from ui.until_free()
    np.testing.assert_allclose(scenes.key_positions(bar()), bent, atol=NEAR)


def test_blend_is_dragged(ui: Ui) -> Steps:
    """The mesh follows the mouse; a click keeps it, one undo takes it back, and so does Esc in between."""
    bent = add_poses(ui)
    ui.call(bpy.ops.arap.poses_apply, "EXEC_DEFAULT", True, pose="Straight")
    yield
    straight = scenes.key_positions(bar())
    place = handle().matrix_world.copy()

    def way() -> float:
        """Of the top, along x, as a part of the whole."""
        return float((scenes.key_positions(bar()) - straight)[:, 0].max() / (bent - straight)[:, 0].max())

    yield from ui.move_mouse_to_view()
    x, y = ui.mouse
    whole = round(300 * bpy.context.preferences.system.ui_scale)
    ui.call(bpy.ops.arap.poses_blend, "INVOKE_DEFAULT", True, pose="Bent")
    yield from ui.move_mouse(x + whole // 2, y)
    yield from ui.until(lambda: way() > 0.3, "the mesh follows the mouse")
    half = way()
    yield from ui.screenshot("half")
    yield from ui.move_mouse(x + 2 * whole, y)
    yield from ui.until(lambda: way() > 0.97, "the mesh has come to the second pose, and not further")
    yield from ui.key("ESC")
    yield
    np.testing.assert_array_equal(scenes.key_positions(bar()), straight)
    assert handle().matrix_world == place
    yield from ui.move_mouse(x, y)
    ui.call(bpy.ops.arap.poses_blend, "INVOKE_DEFAULT", True, pose="Bent")
    yield from ui.move_mouse(x + whole // 2, y)
    yield from ui.key("RET")
    yield from ui.until(lambda: bpy.context.window_manager.operators[-1].bl_idname == "ARAP_OT_poses_blend", "kept")
    assert abs(way() - half) < 0.05
    factor = bpy.context.window_manager.operators[-1].factor
    assert abs(factor - 0.5) < 0.01, "its panel has the factor that was dragged"
    yield from ui.undo()
    np.testing.assert_allclose(scenes.key_positions(bar()), straight, atol=NEAR)
    ui.select(handle())
    yield from begin(ui)
    x, y = ui.mouse
    ui.call(bpy.ops.arap.poses_blend, "INVOKE_DEFAULT", True, pose="Bent")
    yield from ui.move_mouse(x + 2 * whole, y)
    yield from ui.until(lambda: way() > 0.97, "the posing act follows")
    yield from ui.key("ESC")
    yield from ui.until(lambda: way() < 0.03, "Esc has ended the blend")
    assert ui.running, "and not the posing act"
    yield from ui.move_mouse_to_view()  # the drag has ended over another editor, whose Esc is its own
    yield from ui.key("ESC")
    yield from ui.until_free()


def test_export_mesh_cache_browser(ui: Ui) -> Steps:
    """The file browser opens on a name with the end of the format; Esc does nothing, its button exports."""
    animate(ui, 9)
    ui.change(bpy.context.preferences.view, "filebrowser_display_type", "SCREEN")
    bpy.ops.ed.undo_push(message="scene")
    yield from ui.move_mouse_to_view()

    def browsers() -> list[bpy.types.Area]:
        areas = [area for area in ui.window.screen.areas if area.type == "FILE_BROWSER"]
        return [area for area in areas if area.spaces.active.params is not None]

    def open_browser() -> Steps:
        ui.call(bpy.ops.arap.export_mesh_cache)
        yield from ui.until(lambda: bool(browsers()), "the file browser is open")
        assert browsers()[0].spaces.active.params.filename == "Bar.mdd"

    yield from open_browser()
    yield from ui.screenshot("mdd")
    yield from ui.key("ESC")
    yield from ui.until(lambda: not browsers(), "Esc has closed it")
    assert not bar().modifiers
    assert bpy.context.scene.frame_current == 3
    yield from open_browser()
    with tempfile.TemporaryDirectory() as folder:
        browsers()[0].spaces.active.params.directory = folder.encode()
        with ui.override(window=ui.window, area=browsers()[0]):
            bpy.ops.file.execute("INVOKE_DEFAULT")
        yield from ui.until(lambda: bool(bar().modifiers), "the frames are exported")
        assert (Path(folder) / "Bar.mdd").is_file()
    yield from ui.move_mouse_to_view()
    yield from ui.undo()
    assert not bar().modifiers


def test_undo_of_an_act_leaves_follow_off(ui: Ui) -> Steps:
    """What Follow has given up is not tried again by the undo of a later act."""
    bent = add_poses(ui)
    yield from ui.move_mouse_to_view()
    for operator, options in ((bpy.ops.arap.poses_apply, {"pose": "Straight"}), (bpy.ops.arap.poses_to_keys, {})):
        bar().arap.follow_error = "Follow is off"
        bpy.ops.ed.undo_push(message="given up")
        ui.call(operator, "EXEC_DEFAULT", True, **options)
        yield
        yield from ui.until_free()
        yield from ui.undo()
        assert "Bent" not in key_names()
        np.testing.assert_allclose(scenes.key_positions(bar()), bent, atol=NEAR)
        assert not bar().arap.use_follow
