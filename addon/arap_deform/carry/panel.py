# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Carry Along": what goes along with the mesh."""

from __future__ import annotations

from typing import Any

import bpy

from ..ui.checks import posed_object
from ..ui.panels import ArapSubPanel, draw_text, split_column
from . import late
from .keep_up import problem_of
from .problems import left_out_text, owner_of

ICONS = {"bend": "MOD_CLOTH", "rigid": "MESH_UVSPHERE"}


class ARAP_UL_followers(bpy.types.UIList):
    """A tick, how it goes along, the name, and a sign if it cannot."""

    def draw_item(
        self,
        _context: bpy.types.Context,
        layout: bpy.types.UILayout,
        data: Any,
        follower: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        row = layout.row(align=True)
        row.prop(follower, "is_enabled", text="")
        rest = row.row(align=True)
        rest.active = follower.is_enabled
        name = follower.target.name if follower.target is not None else "(gone)"
        rest.label(text=name, translate=False, icon=ICONS.get(follower.kind, "MOD_CLOTH"))
        if follower.is_enabled and problem_of(data.id_data, follower):
            rest.label(text="", icon="ERROR")


class ARAP_PT_carry(ArapSubPanel, bpy.types.Panel):
    bl_label = "Carry Along"
    bl_order = 35
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        settings = obj.arap
        body = owner_of(obj)
        left_out = left_out_text(obj)
        if left_out:
            draw_text(context, layout, f"{left_out}.", "INFO")
        elif body is not None:
            draw_text(context, layout, f"Goes along with '{body.name}'.", "INFO")
        index = settings.active_follower_index
        if settings.followers:
            row = layout.row()
            of_list = (settings, "followers", settings, "active_follower_index")
            row.template_list("ARAP_UL_followers", "", *of_list, rows=3, maxrows=8)
            row.column().operator("arap.carry_remove", text="", icon="REMOVE")
        elif body is None and not left_out:
            text = "Select clothes, hair and eyes, then Shift-click this mesh, and press Carry Along."
            draw_text(context, layout, text, "INFO")
        follower = settings.followers[index] if 0 <= index < len(settings.followers) else None
        if follower is not None:
            split_column(layout).row().prop(follower, "kind", expand=True)
            problem = problem_of(obj, follower) if follower.is_enabled else ""
            if problem:
                draw_text(context, layout, f"{problem}.", "ERROR")
            elif follower.is_enabled and follower.target.session_uid in late.keys:
                draw_text(context, layout, "It is being prepared.", "SORTTIME")
        column = layout.column(align=True)
        column.operator("arap.carry_along", icon="MOD_CLOTH")
        column.operator("arap.carry_near", icon="VIEWZOOM")
        column = layout.column(align=True)
        column.operator("arap.pose_together", icon="MOD_LATTICE")
        if settings.is_stand_in or (body is not None and body.arap.is_stand_in):
            column.operator("arap.stand_in_remove", icon="X")
