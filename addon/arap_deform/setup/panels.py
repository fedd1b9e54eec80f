# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panels "Pins", "Handles" and "Stiffness": a list, the settings of its chosen entry, and its buttons."""

from __future__ import annotations

from typing import Any

import bpy

from ..scene import remembered
from ..scene.inputs import settings_of
from ..ui.checks import find_posed_object, posed_object
from ..ui.panels import ArapPanel, ArapSubPanel, draw_text, is_following, split_column
from .group_operators import is_painted
from .handles import HANDLES, handle_problem
from .pins import PINS, GroupList
from .stiffness import STIFFNESS


class _List:
    """A list with a tick for each entry. draw_entry() draws the rest of the row."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: Any,
        entry: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
        index: int,
    ) -> None:
        obj = find_posed_object(context)
        row = layout.row(align=True)
        row.prop(entry, "is_enabled", text="")
        rest = row.row(align=True)
        rest.active = entry.is_enabled
        if obj is not None:
            self.draw_entry(rest, obj, entry, index)

    def draw_entry(self, row: bpy.types.UILayout, obj: bpy.types.Object, entry: Any, index: int) -> None:
        raise NotImplementedError


def _draw_list(layout: bpy.types.UILayout, settings: Any, kind: GroupList) -> Any | None:
    """A list with a button that removes; returns its chosen entry."""
    entries, index = getattr(settings, kind.items), getattr(settings, kind.active)
    row = layout.row()
    n_rows = min(4, max(2, len(entries)))
    row.template_list(f"ARAP_UL_{kind.items}", "", settings, kind.items, settings, kind.active, rows=n_rows)
    row.column().operator(f"arap.{kind.noun}_remove", text="", icon="REMOVE")
    return entries[index] if index < len(entries) else None


class ARAP_UL_pins(_List, bpy.types.UIList):
    def draw_entry(self, row: bpy.types.UILayout, obj: bpy.types.Object, entry: Any, _index: int) -> None:
        _draw_group_name(row, obj, entry.name, "PINNED")


class ARAP_PT_pins(ArapSubPanel, bpy.types.Panel):
    bl_label = "Pins"
    bl_order = 10

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        pin = _draw_list(layout, obj.arap, PINS)
        if pin is not None:
            split_column(layout).prop_search(pin, "name", obj, "vertex_groups", text="Group")
            _draw_group_buttons(layout, obj, pin.name)
        layout.operator("arap.pin_add", icon="PINNED")


class ARAP_UL_handles(_List, bpy.types.UIList):
    """Handles: the name, and a sign if the handle cannot work."""

    def draw_entry(self, row: bpy.types.UILayout, obj: bpy.types.Object, entry: Any, index: int) -> None:
        row.prop(entry, "name", text="", emboss=False, icon="BONE_DATA" if entry.bone else "EMPTY_AXIS")
        if _handle_problem(obj, index):
            row.label(text="", icon="ERROR")


class ARAP_PT_handles(ArapSubPanel, bpy.types.Panel):
    bl_label = "Handles"
    bl_order = 20

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        handle = _draw_list(layout, obj.arap, HANDLES)
        if handle is not None:
            _draw_handle(layout, obj, handle)
            problem = _handle_problem(obj, obj.arap.active_handle_index)
            if problem:
                draw_text(context, layout, problem, "ERROR")
        column = layout.column(align=True)
        if remembered.has_foreign_handles(obj):
            column.operator("arap.handles_copy", icon="DUPLICATE")
        column.operator("arap.handle_add", icon="VERTEXSEL")
        column.operator("arap.handle_add_from_empties", icon="EMPTY_AXIS")


class ARAP_PT_handle_look(ArapPanel, bpy.types.Panel):
    bl_label = "Look"
    bl_parent_id = "ARAP_PT_handles"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        split_column(self.layout).prop(posed_object(context).arap, "handle_size")


class ARAP_UL_stiffness(_List, bpy.types.UIList):
    """Entries: the vertex group, and how stiff."""

    def draw_entry(self, row: bpy.types.UILayout, obj: bpy.types.Object, entry: Any, _index: int) -> None:
        split = row.split(factor=0.65)
        _draw_group_name(split, obj, entry.name, "MESH_ICOSPHERE" if entry.is_rigid else "MOD_ARMATURE")
        value = split.row()
        value.alignment = "RIGHT"
        value.label(text="Rigid" if entry.is_rigid else f"{entry.factor:.3g} x", translate=False)


class ARAP_PT_stiffness(ArapSubPanel, bpy.types.Panel):
    bl_label = "Stiffness"
    bl_order = 25
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        entry = _draw_list(layout, obj.arap, STIFFNESS)
        if entry is not None:
            column = split_column(layout)
            column.prop_search(entry, "name", obj, "vertex_groups", text="Group")
            if not entry.is_rigid:
                column.prop(entry, "factor", slider=True)
            column.prop(entry, "is_rigid")
            if entry.is_rigid:
                column.prop(entry, "is_one_body")
            _draw_group_buttons(layout, obj, entry.name)
        column = layout.column(align=True)
        column.operator("arap.rigid_add", icon="MESH_ICOSPHERE")
        column.operator("arap.stiffness_add", icon="MOD_ARMATURE")


def _draw_handle(layout: bpy.types.UILayout, obj: bpy.types.Object, handle: Any) -> None:
    column = split_column(layout)
    column.prop(handle, "target")
    if handle.target is not None and handle.target.type == "ARMATURE":
        column.prop_search(handle, "bone", handle.target.data, "bones")
    column.prop_search(handle, "vertex_group", obj, "vertex_groups", text="Group")
    if settings_of(obj).has_radius:
        column.prop(handle, "is_exact")
    _draw_group_buttons(layout, obj, handle.vertex_group)


def _handle_problem(obj: bpy.types.Object, index: int) -> str:
    """Why an enabled handle cannot work, '' if it can."""
    if not obj.arap.handles[index].is_enabled:
        return ""
    return handle_problem(obj, index, with_weights=not is_following(obj))


def _draw_group_name(layout: bpy.types.UILayout, obj: bpy.types.Object, group: str, icon: str) -> None:
    """The name of a vertex group, red with the reason if the group holds nothing."""
    lack = lack_of_group(obj, group)
    label = layout.row()
    label.alert = bool(lack)
    label.label(text=f"{group} ({lack})" if lack else group, translate=False, icon=icon)


def lack_of_group(obj: bpy.types.Object, group: str) -> str:
    """Why a group holds nothing, '' if it does."""
    if group not in obj.vertex_groups:
        return "no such group"
    return "no weights" if not is_following(obj) and remembered.is_empty_group(obj, group) else ""


def _draw_group_buttons(layout: bpy.types.UILayout, obj: bpy.types.Object, vertex_group: str) -> None:
    """Paint, select, soften the group of the chosen entry."""
    row = layout.row(align=True)
    row.enabled = vertex_group in obj.vertex_groups
    for operator, text, is_pressed in (
        ("arap.group_paint", "Paint", is_painted(obj, vertex_group)),
        ("arap.group_select", "Select", False),
        ("arap.group_soften", "Soften", False),
    ):
        row.operator(operator, text=text, depress=is_pressed).vertex_group = vertex_group
