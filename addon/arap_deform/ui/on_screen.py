# SPDX-License-Identifier: GPL-3.0-or-later
"""Written over the finished picture of a 3D view: where there is room, text, and a bar of progress."""

from __future__ import annotations

from dataclasses import dataclass

import blf
import bpy
import numpy as np

from ..core.arrays import Floats
from .batches import draw_pixels
from .waits import Wait

FONT = 0
# Of the bar, in pixels at UI scale 1. Below it there is room for the legend of Stretch.
WIDTH, HEIGHT, ROUND, PADDING, GAP, MARGIN = 280.0, 26.0, 5.0, 10.0, 24.0, 72.0
WIDTH_STEP = 40.0  # so that a number that grows does not move the edges
ESC = "Esc: cancel"
ARC = np.column_stack([np.cos(np.linspace(0, np.pi / 2, 7)), np.sin(np.linspace(0, np.pi / 2, 7))])
QUARTER_TURN = np.array([[0.0, 1.0], [-1.0, 0.0]])  # of rows


@dataclass(frozen=True)
class Room:
    """The part of a region that no other region covers, in pixels of it."""

    left: float
    right: float
    bottom: float


def free_room(context: bpy.types.Context) -> Room:
    region = context.region
    left, right, bottom = 0, region.width, 0
    for other in context.area.regions:
        if other.width <= 1 or other.height <= 1:
            continue  # hidden
        if other.type in {"UI", "TOOLS"}:
            if other.x > region.x:
                right = min(right, other.x - region.x)
            else:
                left = max(left, other.x + other.width - region.x)
        elif other.type not in {"WINDOW", "HUD"} and other.y <= region.y:
            bottom = max(bottom, other.y + other.height - region.y)
    return Room(float(left), float(right), float(bottom))


def draw_text(text: str, x: float, bottom: float, part: float = 0.0) -> None:
    """``part``: of the text's width that lies left of ``x``. Size and colour are set before."""
    blf.position(FONT, x - part * blf.dimensions(FONT, text)[0], bottom, 0.0)
    blf.draw(FONT, text)


def draw_wait(context: bpy.types.Context, wait: Wait) -> None:
    """A bar at the bottom of the view, as Blender draws those of its own; smaller if there is no room."""
    scale = context.preferences.system.ui_scale
    room = free_room(context)
    middle, available = 0.5 * (room.left + room.right), room.right - room.left - 2 * PADDING * scale
    points = context.preferences.ui_styles[0].widget.points
    keys = ESC if wait.ends_on_esc else ""
    blf.size(FONT, points * scale)
    width = _bar_width(wait.text, keys, scale)
    if width > available > 0.0:
        scale, width = scale * available / width, available
        blf.size(FONT, points * scale)
    left, right = round(middle - 0.5 * width), round(middle + 0.5 * width)
    bottom, height = round(room.bottom + MARGIN * scale), round(HEIGHT * scale)
    _draw_bar(context, np.array([left, bottom, right, bottom + height], dtype=np.float64), wait.fraction, scale)
    baseline = bottom + 0.5 * (height - 0.7 * points * scale)
    draw_text(wait.text, left + PADDING * scale, baseline)
    draw_text(keys, right - PADDING * scale, baseline, 1.0)


def _bar_width(text: str, keys: str, scale: float) -> float:
    inner = float(blf.dimensions(FONT, text)[0] + blf.dimensions(FONT, keys)[0])
    needed = inner + (2 * PADDING + GAP) * scale
    step = WIDTH_STEP * scale
    return max(WIDTH * scale, float(np.ceil(needed / step)) * step)


def _draw_bar(context: bpy.types.Context, box: Floats, fraction: float, scale: float) -> None:
    """``box``: left, bottom, right, top. Leaves the colour of text set."""
    colors = context.preferences.themes[0].user_interface.wcol_progress
    border = np.array([-1.0, -1.0, 1.0, 1.0]) * max(1.0, round(scale))
    corners = _rounded(box, ROUND * scale)
    _draw_convex(_rounded(box + border, ROUND * scale + border[2]), (*colors.outline[:3], 1.0))
    _draw_convex(corners, (*colors.inner[:3], 1.0))
    if fraction > 0.0:
        end = box[0] + max(ROUND * scale, min(fraction, 1.0) * (box[2] - box[0]))
        _draw_convex(np.column_stack([np.minimum(corners[:, 0], end), corners[:, 1]]), (*colors.item[:3], 1.0))
    blf.color(FONT, *colors.text[:3], 1.0)


def _rounded(box: Floats, radius: float) -> Floats:
    """(k, 2) the outline of a box with round corners, counterclockwise."""
    left, bottom, right, top = box + radius * np.array([1.0, 1.0, -1.0, -1.0])
    arc, outline = radius * ARC, []
    for middle in ((right, top), (left, top), (left, bottom), (right, bottom)):
        outline.append(middle + arc)
        arc = arc @ QUARTER_TURN
    return np.concatenate(outline)


def _draw_convex(outline: Floats, color: tuple[float, float, float, float]) -> None:
    middle = np.broadcast_to(outline.mean(axis=0), outline.shape)
    triangles = np.stack([middle, outline, np.roll(outline, -1, axis=0)], axis=1)
    draw_pixels("TRIS", triangles.reshape(-1, 2), color)
