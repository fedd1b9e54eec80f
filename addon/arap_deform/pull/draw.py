# SPDX-License-Identifier: GPL-3.0-or-later
"""What ARAP Pull shows: the circle and the patch under the mouse, the line of a drag, the temporary pins.

All in pixels, over the finished picture: moving the mouse draws no 3D view anew.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..core.arrays import Floats
from ..ui import batches, colors
from ..ui.checks import find_drawn_object, find_posed_object
from ..ui.colors import Color
from . import seen_mesh
from .run import runs
from .view import View

CIRCLE = np.column_stack([np.cos(np.linspace(0, 2 * np.pi, 49)), np.sin(np.linspace(0, 2 * np.pi, 49))])
PIN_PX = 5.0  # radius of a pin's dot, in pixels of a display of usual density
PATCH_ALPHA = 0.35

Hover = tuple[object, "seen_mesh.Pick | None"]

_hover: Hover | None = None
"""What was under the mouse the last time, and where that was looked for."""


def draw_cursor(context: bpy.types.Context, xy: tuple[int, int]) -> None:
    """For WorkSpaceTool.draw_cursor(): ``xy`` in pixels of the window."""
    if not hasattr(bpy.types.Object, "arap"):
        return  # the add-on was disabled with the tool in hand in another workspace
    region, region_data = context.region, context.region_data
    obj = find_posed_object(context)
    if region is None or region_data is None:
        return
    corner = np.array([region.x, region.y], dtype=np.float64)
    mouse = np.array(xy, dtype=np.float64) - corner
    radius = float(context.window_manager.arap_pull.radius)
    color = colors.of_pull()
    run = runs[0] if runs else None
    if run is not None and not run.is_released:
        place = run.grip.view.pixels(np.stack([run.grip.pick.place, run.drag.place]))
        draw_lines(corner + place, color)
        draw_lines(corner + place[1] + radius * CIRCLE, color)
        return
    if obj is not None and obj.mode == "OBJECT" and obj.name not in {r.scene.name for r in runs}:
        view = seen_mesh.view_of(region, region_data)
        pick = hover(context, obj, view, (float(mouse[0]), float(mouse[1])), radius)
        if pick is not None:
            _draw_patch(context, obj, view, pick, corner, color)
    draw_lines(corner + mouse + radius * CIRCLE, color)


def hover(
    context: bpy.types.Context, obj: bpy.types.Object, view: View, mouse: tuple[float, float], radius: float
) -> seen_mesh.Pick | None:
    """What is under the mouse; looked up once for each place of the mouse, view and state of the mesh."""
    global _hover  # noqa: PLW0603 - the last one is remembered, drawing functions keep nothing
    try:
        seen = seen_mesh.read(obj, context.evaluated_depsgraph_get())
        now = (obj.name, seen, mouse, radius, view.perspective.tobytes(), view.size)
        if _hover is None or not _is_same(_hover[0], now):
            _hover = (now, seen_mesh.pick(obj, context.evaluated_depsgraph_get(), view, mouse, radius))
        return _hover[1]
    except (ValueError, RuntimeError):  # a press says why; a picture of the mouse only shows nothing
        return None


def _is_same(former: object, now: tuple[object, ...]) -> bool:
    assert isinstance(former, tuple)
    return former[1] is now[1] and former[0] == now[0] and former[2:] == now[2:]


def _draw_patch(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    view: View,
    pick: seen_mesh.Pick,
    corner: Floats,
    color: Color,
) -> None:
    seen = seen_mesh.read(obj, context.evaluated_depsgraph_get())
    triangles = seen_mesh.patch_triangles(seen, pick.vertices)
    if len(triangles):
        pixels = view.pixels(seen.positions[triangles.ravel()]).reshape(-1, 3, 2)
        first, second = pixels[:, 1] - pixels[:, 0], pixels[:, 2] - pixels[:, 0]
        area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        # The far side would cover it twice; what the mouse is over is most of it, whichever way its faces go round.
        is_front = area * np.nansum(area) > 0.0
        draw_triangles(corner + pixels[is_front].reshape(-1, 2), (*color[:3], PATCH_ALPHA))
    else:
        draw_dots(corner + view.pixels(seen.positions[pick.vertices]), PIN_PX, color)


def draw_pins() -> None:
    """A dot for each temporary pin of the mesh; white where it was pulled, else in the colour of the theme."""
    context = bpy.context
    obj = find_drawn_object(context)
    if obj is None or obj.mode != "OBJECT" or not obj.arap.pull_pins or context.region_data is None:
        return
    try:
        seen = seen_mesh.read(obj, context.evaluated_depsgraph_get())
    except ValueError:
        return
    pins = [(pin.vertices, pin.reach) for pin in obj.arap.pull_pins if pin.n_vertices == len(seen.positions)]
    if not pins:
        return
    view = seen_mesh.view_of(context.region, context.region_data)
    centres = np.array([seen.positions[vertices].mean(axis=0) for vertices, _ in pins])
    is_set = np.array([reach == 0.0 for _, reach in pins])
    pixels = view.pixels(centres)
    color = colors.of_pull()
    draw_dots(pixels, PIN_PX + 1.5, (0.0, 0.0, 0.0, 0.8))
    draw_dots(pixels[is_set], PIN_PX, color)
    draw_dots(pixels[~is_set], PIN_PX, (1.0, 1.0, 1.0, 1.0))


def draw_dots(pixels: Floats, radius: float, color: Color) -> None:
    """Filled circles about those of (k, 2) points that are numbers; radius in pixels of a display of usual density."""
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    radius *= bpy.context.preferences.system.ui_scale
    fan = np.stack([np.zeros((48, 2)), CIRCLE[:-1], CIRCLE[1:]], axis=1).reshape(-1, 2)
    draw_triangles((pixels[:, None] + radius * fan[None]).reshape(-1, 2), color)


def draw_lines(pixels: Floats, color: Color) -> None:
    """One line through those of (k, 2) points that are numbers."""
    batches.draw_pixels("LINE_STRIP", pixels[np.isfinite(pixels).all(axis=1)], color)


def draw_triangles(pixels: Floats, color: Color) -> None:
    """(3 t, 2) corners."""
    batches.draw_pixels("TRIS", pixels, color)


def clear() -> None:
    """Forgets what was under the mouse."""
    global _hover  # noqa: PLW0603
    _hover = None


_handle: object | None = None


def register() -> None:
    global _handle  # noqa: PLW0603 - Blender's way to take it off again
    if not bpy.app.background:
        _handle = bpy.types.SpaceView3D.draw_handler_add(draw_pins, (), "WINDOW", "POST_PIXEL")


def unregister() -> None:
    global _handle  # noqa: PLW0603
    if _handle is not None:
        bpy.types.SpaceView3D.draw_handler_remove(_handle, "WINDOW")
        _handle = None
    clear()
