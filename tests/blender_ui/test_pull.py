# SPDX-License-Identifier: GPL-3.0-or-later
"""ARAP Pull, as an artist does it: with the mouse and keys, in a window."""

import bpy
import numpy as np
import scenes
from bpy_extras.view3d_utils import location_3d_to_region_2d
from harness import Steps, Ui
from mathutils import Vector

NEAR = 1e-4
N = 41  # vertices along a side of the sheet, which is two units wide


def sheet() -> bpy.types.Object:
    return bpy.data.objects["Grid"]


def begin(ui: Ui, n: int = N) -> Steps:
    """A flat sheet seen from above, and the tool in hand."""
    scenes.add_grid(n)
    region = ui.view.spaces.active.region_3d
    region.view_perspective = "ORTHO"
    region.view_rotation = (1.0, 0.0, 0.0, 0.0)
    region.view_location = (0.0, 0.0, 0.0)
    region.view_distance = 4.0
    yield from ui.move_mouse_to_view()
    assert ui.call(bpy.ops.arap.pull_tool) == {"FINISHED"}
    bpy.context.window_manager.arap_pull.radius = 25
    bpy.ops.ed.undo_push(message="scene")
    yield


def point_at(ui: Ui, place: tuple[float, float, float]) -> Steps:
    """Moves the mouse over a place in the world."""
    yield from ui.move_mouse(*pixel(ui, place))


def pixel(ui: Ui, place: tuple[float, float, float]) -> tuple[int, int]:
    region = ui.region()
    x, y = location_3d_to_region_2d(region, ui.view.spaces.active.region_3d, Vector(place))
    return round(region.x + x), round(region.y + y)


def press(ui: Ui, place: tuple[float, float, float], **modifiers: bool) -> Steps:
    yield from point_at(ui, place)
    ui.event("LEFTMOUSE", "PRESS", **modifiers)
    yield


def drag_to(ui: Ui, place: tuple[float, float, float], n_steps: int = 4, **modifiers: bool) -> Steps:
    start, end = np.array(ui.mouse), np.array(pixel(ui, place))
    for i in range(1, n_steps + 1):
        ui.mouse = tuple(int(value) for value in np.round(start + (end - start) * i / n_steps))
        ui.event("MOUSEMOVE", "NOTHING", **modifiers)
        yield


def release(ui: Ui) -> Steps:
    ui.event("LEFTMOUSE", "RELEASE")
    yield from ui.until(lambda: not ui.running, "the pull has settled")
    yield


def pull(ui: Ui, start: tuple[float, float, float], end: tuple[float, float, float]) -> Steps:
    """One whole drag."""
    yield from press(ui, start)
    yield from drag_to(ui, end)
    yield from release(ui)


def nearest(rest: np.ndarray, place: tuple[float, float, float]) -> int:
    return int(np.linalg.norm(rest - place, axis=1).argmin())


def test_pull_undo_redo(ui: Ui) -> Steps:
    """A drag takes the patch with the mouse, live; the rest beyond the falloff stays; one undo takes it back."""
    yield from begin(ui)
    rest = scenes.key_positions(sheet())
    middle = nearest(rest, (0.0, 0.0, 0.0))
    yield from point_at(ui, (0.0, 0.0, 0.0))
    yield from ui.screenshot("hover")
    yield from press(ui, (0.0, 0.0, 0.0))
    yield from drag_to(ui, (0.3, 0.1, 0.0))
    assert "Grid" in ui.running
    yield from ui.until(lambda: scenes.shown_positions(sheet())[middle][0] > 0.25, "the mesh follows")
    yield from ui.screenshot("dragging")
    yield from release(ui)
    posed = scenes.shown_positions(sheet())
    np.testing.assert_allclose(posed[middle], (0.3, 0.1, 0.0), atol=0.02)
    far = np.abs(rest[:, :2]).max(axis=1) > 0.9
    np.testing.assert_allclose(posed[far], rest[far], atol=NEAR)
    assert len(sheet().arap.pull_pins) == 1
    yield from ui.screenshot("released")
    yield from ui.key("Z", ctrl=True)
    yield
    np.testing.assert_allclose(scenes.shown_positions(sheet()), rest, atol=NEAR)
    assert len(sheet().arap.pull_pins) == 0
    assert sheet().data.shape_keys is None
    yield from ui.key("Z", ctrl=True, shift=True)
    yield
    np.testing.assert_allclose(scenes.shown_positions(sheet()), posed, atol=1e-6)
    assert len(sheet().arap.pull_pins) == 1
