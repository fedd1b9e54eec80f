# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons below a list for the vertex group of what is chosen in it."""

from __future__ import annotations

import bpy

from .operators.groups import is_painted


def draw_group_buttons(layout: bpy.types.UILayout, obj: bpy.types.Object, vertex_group: str) -> None:
    """Paint, select, soften."""
    row = layout.row(align=True)
    row.enabled = vertex_group in obj.vertex_groups
    is_on = is_painted(obj, vertex_group)
    for operator, text, icon in (
        ("arap.group_paint", "Paint", "BRUSH_DATA"),
        ("arap.group_select", "Select", "RESTRICT_SELECT_OFF"),
        ("arap.group_soften", "Soften", "SMOOTHCURVE"),
    ):
        button = row.operator(operator, text=text, icon=icon, depress=is_on and operator == "arap.group_paint")
        button.vertex_group = vertex_group
