# SPDX-License-Identifier: GPL-3.0-or-later
"""The legend of the stretch colours, in the lower right corner of the view."""

from __future__ import annotations

import blf
import bpy
import gpu
import numpy as np

from ..ui.batches import index_buffer, surface_batch
from ..ui.on_screen import FONT, draw_text, free_room
from .strain import colors_of

WIDTH, HEIGHT, MARGIN, TEXT_SIZE = 180.0, 10.0, 24.0, 11.0
TITLE = "Stretch: edges shorter or longer than at rest"


def draw_legend(context: bpy.types.Context, limit: float) -> None:
    """A bar of the colours, with percent at its ends and middle, left of the sidebar.

    Args:
        context: of the view.
        limit: the stretch of the full colour, in percent.
    """
    scale = context.preferences.system.ui_scale
    width, height = WIDTH * scale, HEIGHT * scale
    room = free_room(context)
    left = room.right - (WIDTH + MARGIN) * scale
    bottom = room.bottom + MARGIN * scale + 1.5 * TEXT_SIZE * scale
    _draw_bar(left, bottom, width, height)
    blf.size(FONT, TEXT_SIZE * scale)
    color = context.preferences.themes[0].view_3d.space.text_hi
    blf.color(FONT, color[0], color[1], color[2], 1.0)
    below = bottom - 1.3 * TEXT_SIZE * scale
    for text, part in ((f"-{limit:g} %", 0.0), ("0", 0.5), (f"+{limit:g} %", 1.0)):
        draw_text(text, left + part * width, below, 0.5)
    draw_text(TITLE, left + 0.5 * width, bottom + height + 0.4 * TEXT_SIZE * scale, 0.5)


def _draw_bar(left: float, bottom: float, width: float, height: float) -> None:
    parts = np.linspace(-1.0, 1.0, 3, dtype=np.float32)
    x = left + (parts + 1.0) * 0.5 * width
    corners = [(x[i], y, 0.0) for y in (bottom, bottom + height) for i in range(3)]
    colors = colors_of(np.tile(parts, 2), 1.0)
    triangles = np.array([(0, 1, 4), (0, 4, 3), (1, 2, 5), (1, 5, 4)], dtype=np.int32)
    batch = surface_batch(np.array(corners, dtype=np.float32), colors, index_buffer(triangles))
    gpu.state.blend_set("ALPHA")
    batch.draw(gpu.shader.from_builtin("SMOOTH_COLOR"))
    gpu.state.blend_set("NONE")
