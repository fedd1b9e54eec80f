# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Stiffness": the list of groups that bend less than the rest."""

from __future__ import annotations

from typing import Any

import bpy

from ..ui.checks import find_posed_object, posed_object
from ..ui.panels import ArapSubPanel, draw_list, split_column
from .group_buttons import draw_group_buttons
from .pin_panel import lack_of_group

ADD_BY_MODE = {"EDIT": "Stiffen Selected Vertices", "WEIGHT_PAINT": "New Group to Paint"}


class ARAP_UL_stiffness(bpy.types.UIList):
    """Entries: on or off, the vertex group, how stiff."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: Any,
        entry: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        obj = find_posed_object(context)
        lack = "" if obj is None else lack_of_group(obj, entry.name)
        row = layout.row(align=True)
        row.prop(entry, "is_enabled", text="")
        split = row.split(factor=0.65)
        split.active = entry.is_enabled
        label = split.row()
        label.alert = bool(lack)
        text = f"{entry.name} ({lack})" if lack else entry.name
        label.label(text=text, translate=False, icon="MESH_ICOSPHERE" if entry.is_rigid else "MOD_ARMATURE")
        value = split.row()
        value.alignment = "RIGHT"
        value.label(text="Rigid" if entry.is_rigid else f"{entry.factor:.3g} x", translate=False)


class ARAP_PT_stiffness(ArapSubPanel, bpy.types.Panel):
    """The list, and what belongs to the entry chosen in it."""

    bl_idname = "ARAP_PT_stiffness"
    bl_label = "Stiffness"
    bl_order = 25
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        settings = obj.arap
        buttons = ("arap.stiffness_add", "arap.stiffness_remove")
        draw_list(layout, settings, "ARAP_UL_stiffness", "stiffness", "active_stiffness_index", *buttons)
        if settings.active_stiffness_index < len(settings.stiffness):
            _draw_entry(layout, obj, settings.stiffness[settings.active_stiffness_index])
        column = layout.column(align=True)
        column.operator("arap.rigid_add", text="Make Selected Rigid", icon="MESH_ICOSPHERE")
        column.operator(
            "arap.stiffness_add",
            text=ADD_BY_MODE.get(obj.mode, "Stiffen Vertex Group"),
            icon="MOD_ARMATURE",
        )


def _draw_entry(layout: bpy.types.UILayout, obj: bpy.types.Object, entry: Any) -> None:
    column = split_column(layout)
    column.prop_search(entry, "name", obj, "vertex_groups", text="Group")
    if not entry.is_rigid:
        column.prop(entry, "factor", slider=True)
    column.prop(entry, "is_rigid")
    if entry.is_rigid:
        column.prop(entry, "is_one_body")
    draw_group_buttons(layout, obj, entry.name)


CLASSES = (ARAP_UL_stiffness, ARAP_PT_stiffness)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
