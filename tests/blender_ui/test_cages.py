# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage in a window: made by a button, edited in Edit Mode with G and O, undone, kept."""

import bpy
import numpy as np
import scenes
from camera import begin_pull, look
from harness import Steps, Ui
from test_live import bar, settle
from test_pose import select_vertices

NEAR = 1e-4


def make_cage(ui: Ui) -> bpy.types.Object:
    """By the button; returns the cage, which is the active object now."""
    assert ui.call(bpy.ops.arap.cage_make) == {"FINISHED"}
    return bpy.context.object


def ring(cage: bpy.types.Object, height: float) -> list[int]:
    """Its vertices above a height."""
    return [vertex.index for vertex in cage.data.vertices if vertex.co.z > height]


def assert_moved(rest: np.ndarray, way: float) -> None:
    """The bar is shown moved along X."""
    np.testing.assert_allclose(scenes.shown_positions(bar()), rest + np.array([way, 0.0, 0.0]), atol=NEAR)


def move(ui: Ui, axis: str, amount: str) -> Steps:
    """G along an axis, confirmed."""
    ui.press("G")
    ui.press(axis)
    for letter in amount:
        ui.press_letter(letter)
    yield
    ui.press("RET")
    yield


def test_the_mesh_follows_an_edited_cage_and_undo(ui: Ui) -> Steps:
    """Make Cage, Tab, G: the mesh follows. Undo takes the moves back one by one, Cancel all of it."""
    ui.change(ui.live_run, "HEAVY_STEP_S", float("inf"))
    scenes.add_bar()
    yield from ui.move_mouse_to_view()
    cage = make_cage(ui)
    yield from settle(ui)
    rest = scenes.shown_positions(bar())
    bpy.ops.object.mode_set(mode="EDIT")
    select_vertices(cage, list(range(len(cage.data.vertices))))
    bpy.ops.ed.undo_push(message="selected")
    for way in (1.0, 2.0):
        yield from move(ui, "X", "1")
        yield from settle(ui)
        assert_moved(rest, way)
    yield from ui.undo()
    yield from settle(ui)
    assert_moved(rest, 1.0)
    assert bpy.data.objects["Bar Cage"].mode == "EDIT"
    assert (bar().arap.is_live, bar().arap.live_problem) == (True, "")
    yield from ui.key("TAB")
    yield from settle(ui)
    assert_moved(rest, 1.0)
    assert ui.call(bpy.ops.arap.follow_end, is_kept=False) == {"FINISHED"}
    yield
    assert_moved(rest, 0.0)
    assert not bar().arap.is_live
    yield from ui.undo()
    yield from settle(ui)
    assert_moved(rest, 1.0)


def test_a_vertex_added_by_mistake_is_taken_back_by_undo(ui: Ui) -> Steps:
    """Follow waits and says why; Ctrl-Z goes on."""
    scenes.add_bar()
    yield from ui.move_mouse_to_view()
    cage = make_cage(ui)
    yield from settle(ui)
    bpy.ops.object.mode_set(mode="EDIT")
    select_vertices(cage, ring(cage, 4.0))
    bpy.ops.ed.undo_push(message="selected")
    with ui.override():
        bpy.ops.mesh.subdivide("EXEC_DEFAULT", True)
    yield
    yield
    assert "vertices now, but had" in ui.live.run_of(bar()).pause
    yield from ui.undo()
    yield from settle(ui)
    assert (bar().arap.is_live, bar().arap.live_problem) == (True, "")


def test_a_bind_is_shown_and_esc_ends_it(ui: Ui) -> Steps:
    """Harmonic coordinates take a second: the bar in the view shows how far they are, Esc switches Follow off."""
    scenes.add_bar()
    yield from ui.move_mouse_to_view()
    make_cage(ui)
    yield from settle(ui)
    with ui.held_stage(after=1.0):
        bar().arap.handles[0].coordinates = "harmonic"
        yield from ui.until_held()
        yield from ui.until_bar("Preparing")
        yield from ui.key("ESC")
        yield from ui.until_no_bar()
    assert not bar().arap.is_live
    bar().arap.is_live = True
    yield from settle(ui)


def test_the_panel_with_a_cage(ui: Ui) -> Steps:
    """The creature in its cage, the tab in every state of it: for eyes."""
    ui.open_panels("ARAP_PT_entry", "ARAP_PT_advanced")
    creature = yield from begin_pull(ui)
    yield from ui.open_tab()
    look(ui, right=-0.9, up=0.25)
    yield from ui.screenshot("1_before")
    cage = make_cage(ui)
    yield from ui.until(lambda: ui.live.run_of(creature).is_settled, "it is bound")
    yield from ui.screenshot("2_made")
    bpy.ops.object.mode_set(mode="EDIT")
    select_vertices(cage, [v.index for v in cage.data.vertices if v.co.z > 1.4])
    bpy.ops.ed.undo_push(message="selected")
    yield from ui.move_mouse_to_view()
    bpy.context.scene.tool_settings.use_proportional_edit = True
    bpy.context.scene.tool_settings.proportional_size = 0.7
    yield from move(ui, "Y", "-.4")
    yield from ui.screenshot("3_edited")
    bpy.ops.object.mode_set(mode="OBJECT")
    ui.api.add_pin(creature, range(40), name="Feet")
    yield from ui.screenshot("4_with_a_pin")
    creature.arap.handles[0].is_enabled = False
    yield from ui.screenshot("5_off")
