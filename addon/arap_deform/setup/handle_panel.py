# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Handles": the list of handles, and how their empties look."""

from __future__ import annotations

from typing import Any

import bpy

from ..scene.inputs import settings_of
from ..ui.checks import find_posed_object, posed_object
from ..ui.panels import ArapPanel, ArapSubPanel, draw_list, draw_text, is_following, split_column
from .group_buttons import draw_group_buttons
from .handles import handle_problem


class ARAP_UL_handles(bpy.types.UIList):
    """Handles: on or off, name, and a sign where one cannot work."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: Any,
        handle: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
        index: int,
    ) -> None:
        obj = find_posed_object(context)
        row = layout.row(align=True)
        row.prop(handle, "is_enabled", text="")
        name = row.row(align=True)
        name.active = handle.is_enabled
        name.prop(handle, "name", text="", emboss=False, icon="BONE_DATA" if handle.bone else "EMPTY_AXIS")
        if obj is not None and settings_of(obj).has_radius:
            row.prop(handle, "is_exact", text="", icon="SNAP_VERTEX")
        if obj is not None and _problem(obj, index):
            row.label(text="", icon="ERROR")


class ARAP_PT_handles(ArapSubPanel, bpy.types.Panel):
    """The list of handles."""

    bl_idname = "ARAP_PT_handles"
    bl_label = "Handles"
    bl_order = 20

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        settings = obj.arap
        buttons = ("arap.handle_add", "arap.handle_remove")
        draw_list(layout, settings, "ARAP_UL_handles", "handles", "active_handle_index", *buttons)
        if settings.active_handle_index < len(settings.handles):
            _draw_handle(context, layout, obj, settings.active_handle_index)
        column = layout.column(align=True)
        column.operator("arap.handle_add", text="Add from Selected Vertices", icon="VERTEXSEL")
        column.operator("arap.handle_add_from_empties", text="Add from Selected Empties", icon="EMPTY_AXIS")


class ARAP_PT_handle_look(ArapPanel, bpy.types.Panel):
    """How the handles' empties look."""

    bl_idname = "ARAP_PT_handle_look"
    bl_label = "Look"
    bl_parent_id = "ARAP_PT_handles"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        column = split_column(self.layout)
        settings = posed_object(context).arap
        column.prop(settings, "handle_shape")
        column.prop(settings, "handle_size")
        column.prop(settings, "handle_in_front", text="In Front")
        column.prop(settings, "handle_color")


def _draw_handle(context: bpy.types.Context, layout: bpy.types.UILayout, obj: bpy.types.Object, index: int) -> None:
    handle = obj.arap.handles[index]
    column = split_column(layout)
    column.prop(handle, "target")
    if handle.target is not None and handle.target.type == "ARMATURE":
        column.prop_search(handle, "bone", handle.target.data, "bones")
    column.prop_search(handle, "vertex_group", obj, "vertex_groups", text="Group")
    if settings_of(obj).has_radius:
        column.prop(handle, "is_exact")
    draw_group_buttons(layout, obj, handle.vertex_group)
    problem = _problem(obj, index)
    if problem:
        draw_text(context, layout, problem, "ERROR")


def _problem(obj: bpy.types.Object, index: int) -> str:
    """Why an enabled handle cannot work, '' if it can."""
    if not obj.arap.handles[index].is_enabled:
        return ""
    return handle_problem(obj, index, with_weights=not is_following(obj))


CLASSES = (ARAP_UL_handles, ARAP_PT_handles, ARAP_PT_handle_look)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
