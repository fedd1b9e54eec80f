# SPDX-License-Identifier: GPL-3.0-or-later
"""What ARAP Pull shows: the circle and the patch under the mouse, the line of a drag, the temporary pins.

All but the pins is drawn in pixels over the finished picture, so a move of the mouse does not redraw the 3D view.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..attach.hosts import moving_mesh
from ..core.arrays import Floats
from ..props import preferences
from ..props.bounds import bounded
from ..scene import meshes
from ..ui import batches
from ..ui.batches import Color
from ..ui.checks import find_arap_object, find_drawn_object
from . import evaluated_mesh
from .drag import Mode
from .run import runs
from .view import View

CIRCLE = np.column_stack([np.cos(np.linspace(0, 2 * np.pi, 49)), np.sin(np.linspace(0, 2 * np.pi, 49))])
FAN = np.stack([np.zeros((48, 2)), CIRCLE[:-1], CIRCLE[1:]], axis=1).reshape(-1, 2)  # the triangles of a disc
PIN_PX = 5.0  # radius of the dot of a pin, in pixels at UI scale 1
PATCH_ALPHA = 0.35
BEHIND_ALPHA = 0.3  # of a pin that the mesh hides
OUTLINE: Color = (0.0, 0.0, 0.0, 0.8)  # of a pin
BEYOND: Color = (1.0, 0.25, 0.15, 1.0)  # from where the mesh has followed to, to the mouse

_hover: tuple[object, evaluated_mesh.PickedPatch | None] = (None, None)
"""The last pick under the mouse, after the state in which it was made."""


def draw_cursor(context: bpy.types.Context, xy: tuple[int, int]) -> None:
    """For WorkSpaceTool.draw_cursor(): ``xy`` in pixels of the window."""
    if not hasattr(bpy.types.Object, "arap"):
        return  # the add-on was disabled while another workspace had the tool
    region, region_data = context.region, context.region_data
    in_hand = find_arap_object(context)
    obj = moving_mesh(in_hand) if in_hand is not None else None
    if region is None or region_data is None:
        return
    corner = np.array([region.x, region.y], dtype=np.float64)
    mouse = np.array(xy, dtype=np.float64) - corner
    radius = float(preferences.pull().radius)
    color = batches.color_of_pull()
    run = runs[0] if runs else None
    if run is not None and not run.is_released:
        place = run.grip.view.pixels(np.stack([run.grip.pick.place, run.drag.place, run.drag.wanted]))
        draw_lines(corner + place[:2], color)
        if run.drag.is_beyond:
            draw_lines(corner + place[1:], BEYOND)
        if run.drag.mode is Mode.TURN:
            pivot = run.grip.view.pixels(run.drag.pivot[None])
            draw_dots(corner + pivot, PIN_PX, color)
            draw_lines(corner + np.concatenate([pivot, place[1:2]]), color)
        draw_lines(corner + place[1] + radius * CIRCLE, color)
        return
    is_pulled = obj is not None and obj.session_uid in {r.scene.uid for r in runs}
    if obj is not None and obj.mode == "OBJECT" and not is_pulled:
        view = evaluated_mesh.view_of(region, region_data)
        pick = hover(context, obj, view, (float(mouse[0]), float(mouse[1])), radius)
        if pick is not None:
            _draw_patch(context, obj, view, pick, corner, color)
    draw_lines(corner + mouse + radius * CIRCLE, color)


def hover(
    context: bpy.types.Context, obj: bpy.types.Object, view: View, mouse: tuple[float, float], radius: float
) -> evaluated_mesh.PickedPatch | None:
    """The pick under the mouse; made once for each place of the mouse, view and state of the mesh."""
    global _hover  # noqa: PLW0603 - drawing functions keep nothing, so the module keeps the last pick
    depsgraph = meshes.drawn_depsgraph(context)
    try:
        now = (
            obj.session_uid,
            evaluated_mesh.read(obj, depsgraph),
            mouse,
            radius,
            view.perspective.tobytes(),
            view.size,
        )
        if _hover[0] != now:
            _hover = (now, evaluated_mesh.pick(obj, depsgraph, view, mouse, radius))
        return _hover[1]
    except (ValueError, RuntimeError):  # a press of the mouse says why; the cursor shows no patch
        return None


def _draw_patch(
    context: bpy.types.Context,
    obj: bpy.types.Object,
    view: View,
    pick: evaluated_mesh.PickedPatch,
    corner: Floats,
    color: Color,
) -> None:
    seen = evaluated_mesh.read(obj, meshes.drawn_depsgraph(context))
    triangles = evaluated_mesh.patch_triangles(seen, pick.vertices)
    if len(triangles):
        pixels = view.pixels(seen.positions[triangles.ravel()]).reshape(-1, 3, 2)
        first, second = pixels[:, 1] - pixels[:, 0], pixels[:, 2] - pixels[:, 0]
        area = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        # Only triangles of one winding, or the far side would cover the patch twice. The near side is most of it.
        is_front = area * np.nansum(area) > 0.0
        batches.draw_pixels("TRIS", corner + pixels[is_front].reshape(-1, 2), (*color[:3], PATCH_ALPHA))
    else:
        draw_dots(corner + view.pixels(seen.positions[pick.vertices]), PIN_PX, color)


def draw_pins() -> None:
    """A dot for each temporary pin: white if it was pulled, else in the colour of the theme; pale behind the mesh."""
    context = bpy.context
    obj = find_drawn_object(context)
    if obj is None or obj.mode != "OBJECT" or not obj.arap.pull_pins or context.region_data is None:
        return
    try:
        seen = evaluated_mesh.read(obj, meshes.drawn_depsgraph(context))
    except ValueError:
        return
    of_mesh = [pin for pin in obj.arap.pull_pins if pin.n_vertices == len(seen.positions)]
    pins = [(pin.vertices, bounded(pin, "reach")) for pin in of_mesh if len(pin.vertices)]  # damaged ones have none
    if not pins:
        return
    view = evaluated_mesh.view_of(context.region, context.region_data)
    places = np.array([_middle_of(seen.positions[vertices]) for vertices, _ in pins])
    is_set = np.array([reach == 0.0 for _, reach in pins])
    for is_hidden_behind, alpha in ((False, BEHIND_ALPHA), (True, 1.0)):
        for chosen, color in ((is_set, batches.color_of_pull()), (~is_set, (1.0, 1.0, 1.0, 1.0))):
            if chosen.any():
                for radius, shade in ((PIN_PX + 1.5, OUTLINE), (PIN_PX, color)):
                    discs = facing_discs(view, places[chosen], radius)
                    color_now = (*shade[:3], shade[3] * alpha)
                    batches.draw_faces(discs, color_now, is_hidden_behind=is_hidden_behind)


def _middle_of(places: Floats) -> Floats:
    """(3,) the one of (k, 3) places that is nearest to their mean: it is on the surface."""
    return np.asarray(places[np.linalg.norm(places - places.mean(axis=0), axis=1).argmin()])


def facing_discs(view: View, places: Floats, radius: float) -> Floats:
    """(k, 3) corners of the triangles of discs about places in the world, without places behind the viewer.

    They face the viewer, a radius in front of their places: so a slope does not hide half of one. ``radius`` in pixels
    at UI scale 1.
    """
    radius *= bpy.context.preferences.system.ui_scale
    places = places[np.isfinite(view.pixels(places)).all(axis=1)]
    steps = np.array([view.pixel_steps(place) for place in places]).reshape(-1, 2, 3)
    length = np.linalg.norm(steps[:, 0], axis=1)[:, None]
    front = np.cross(steps[:, 0], steps[:, 1]) / np.where(length > 0.0, length, 1.0)
    corners = places[:, None] + radius * (front[:, None] + FAN @ steps)
    return np.asarray(corners.reshape(-1, 3))


def draw_dots(pixels: Floats, radius: float, color: Color) -> None:
    """Filled circles about (k, 2) points, without NaN points; ``radius`` in pixels at UI scale 1."""
    pixels = pixels[np.isfinite(pixels).all(axis=1)]
    radius *= bpy.context.preferences.system.ui_scale
    batches.draw_pixels("TRIS", (pixels[:, None] + radius * FAN).reshape(-1, 2), color)


def draw_lines(pixels: Floats, color: Color) -> None:
    """One line through (k, 2) points, without NaN points."""
    batches.draw_pixels("LINE_STRIP", pixels[np.isfinite(pixels).all(axis=1)], color)


def clear() -> None:
    """Forgets the last pick."""
    global _hover  # noqa: PLW0603
    _hover = (None, None)


DRAWN = ((draw_pins, "POST_VIEW"),)


def unregister() -> None:
    clear()
