# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons below a list for the vertex group of what is chosen in it."""

from __future__ import annotations

import bpy

from .group_operators import is_painted


def draw_group_buttons(layout: bpy.types.UILayout, obj: bpy.types.Object, vertex_group: str) -> None:
    """Paint, select, soften."""
    row = layout.row(align=True)
    row.enabled = vertex_group in obj.vertex_groups
    is_on = is_painted(obj, vertex_group)
    # Without icons: the words of other languages need the room.
    for operator, text in (
        ("arap.group_paint", "Paint"),
        ("arap.group_select", "Select"),
        ("arap.group_soften", "Soften"),
    ):
        is_pressed = is_on and operator == "arap.group_paint"
        button = row.operator(operator, text=text, depress=is_pressed)
        button.vertex_group = vertex_group
