# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Attach": what is attached to the mesh."""

from __future__ import annotations

from typing import Any

import bpy

from ..ui.checks import arap_object
from ..ui.panels import ArapSubPanel, draw_text, split_column
from . import states
from .operators import selected_besides
from .problems import left_out_text, owner_of
from .stand_in import stand_in_of
from .sync import problem_of

ICONS = {"bend": "MOD_CLOTH", "rigid": "MESH_UVSPHERE"}


class ARAP_UL_attachments(bpy.types.UIList):
    """A tick, the kind, the name, and a sign if the object cannot follow."""

    def draw_item(
        self,
        _context: bpy.types.Context,
        layout: bpy.types.UILayout,
        data: Any,
        attachment: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        row = layout.row(align=True)
        row.prop(attachment, "is_enabled", text="")
        rest = row.row(align=True)
        rest.active = attachment.is_enabled
        name = attachment.object.name if attachment.object is not None else "(gone)"
        rest.label(text=name, translate=False, icon=ICONS.get(attachment.kind, "MOD_CLOTH"))
        if attachment.is_enabled and problem_of(data.id_data, attachment):
            rest.label(text="", icon="ERROR")


class ARAP_PT_attach(ArapSubPanel, bpy.types.Panel):
    bl_label = "Attach"
    bl_order = 35
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = arap_object(context)
        settings = obj.arap
        host = owner_of(obj)
        left_out = left_out_text(obj)
        if left_out:
            draw_text(context, layout, f"{left_out}.", "INFO")
        elif host is not None:
            draw_text(context, layout, f"Attached to '{host.name}'.", "INFO")
        index = settings.active_attachment_index
        if settings.attachments:
            row = layout.row()
            of_list = (settings, "attachments", settings, "active_attachment_index")
            row.template_list("ARAP_UL_attachments", "", *of_list, rows=3, maxrows=8)
            row.column().operator("arap.detach", text="", icon="REMOVE")
        elif host is None and not left_out:
            text = "Select clothes, hair and eyes, then Shift-click this mesh, and press Attach."
            draw_text(context, layout, text, "INFO")
        attachment = settings.attachments[index] if 0 <= index < len(settings.attachments) else None
        if attachment is not None:
            split_column(layout).row().prop(attachment, "kind", expand=True)
            problem = problem_of(obj, attachment) if attachment.is_enabled else ""
            if problem:
                draw_text(context, layout, f"{problem}.", "ERROR")
            elif attachment.is_enabled and states.of(attachment.object.session_uid).pending is not None:
                draw_text(context, layout, "It is being prepared.", "SORTTIME")
        column = layout.column(align=True)
        alone = not selected_besides(context, obj)
        column.operator("arap.attach", text="Attach What Is Near" if alone else "Attach", icon="MOD_CLOTH")
        if host is not None and not settings.attachments:
            column.operator("arap.detach", icon="X")
        column = layout.column(align=True)
        column.operator("arap.stand_in_make", icon="MOD_LATTICE")
        if stand_in_of(obj) is not None:
            column.operator("arap.stand_in_remove", icon="X")
        column.operator("arap.cage_make", icon="MOD_MESHDEFORM")
