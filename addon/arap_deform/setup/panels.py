# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of pins, handles and bones, the settings of its chosen entry, and the sub-panel "Stiffness"."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

from ..scene import ui_cache
from ..scene.snapshot import settings_of
from ..ui.checks import arap_object, find_arap_object
from ..ui.panels import NARROW_FOR_THREE, ArapSubPanel, button_row, draw_text, is_following, split_column
from .chosen import chosen
from .controls import control_problem
from .group_operators import is_painted

if TYPE_CHECKING:
    from ..props.controls import ArapControl


class _List:
    """A list with a tick for each entry. draw_entry() draws the rest of the row."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: Any,
        item: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        obj = find_arap_object(context)
        if obj is None:
            return
        row = layout.row(align=True)
        row.prop(item, "is_enabled", text="")
        rest = row.row(align=True)
        rest.active = item.is_enabled
        self.draw_entry(rest, obj, item)

    def draw_entry(self, row: bpy.types.UILayout, obj: bpy.types.Object, entry: Any) -> None:
        raise NotImplementedError


class ARAP_UL_controls(_List, bpy.types.UIList):
    """Pins, handles and bones: a tick, the name, and a sign if one cannot work."""

    def draw_entry(self, row: bpy.types.UILayout, obj: bpy.types.Object, entry: ArapControl) -> None:
        if entry.is_pin:
            lack = lack_of_group(obj, entry.vertex_group)
            name = row.row(align=True)
            name.alert = bool(lack)
            name.prop(entry, "name", text="", emboss=False, icon="PINNED")
            if lack:
                name.label(text=lack)
            return
        row.prop(entry, "name", text="", emboss=False, icon="BONE_DATA" if entry.bone else "EMPTY_AXIS")
        if _problem_of(obj, entry):
            row.label(text="", icon="ERROR")


def draw_controls(layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """The list of pins, handles and bones, if there are any, with a button that removes the chosen one."""
    settings = obj.arap
    if not settings.controls:
        return
    row = layout.row()
    n_rows = min(6, max(3, len(settings.controls)))
    row.template_list("ARAP_UL_controls", "", settings, "controls", settings, "active_control_index", rows=n_rows)
    row.column().operator("arap.control_remove", text="", icon="REMOVE")


class ARAP_PT_entry(ArapSubPanel, bpy.types.Panel):
    bl_label = "Handle or Pin"
    bl_order = 10
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = arap_object(context)
        control = chosen(obj)
        if control is not None:
            _draw_control(context, layout, obj, control)
        column = layout.column(align=True)
        column.operator("arap.bones_add", icon="BONE_DATA")


class ARAP_UL_stiffness(_List, bpy.types.UIList):
    """Entries: the vertex group, and how stiff."""

    def draw_entry(self, row: bpy.types.UILayout, obj: bpy.types.Object, entry: Any) -> None:
        split = row.split(factor=0.65)
        _draw_group_name(split, obj, entry.name, "MESH_ICOSPHERE" if entry.use_rigid else "MOD_ARMATURE")
        value = split.row()
        value.alignment = "RIGHT"
        value.label(text="Rigid" if entry.use_rigid else f"{entry.factor:.3g} x", translate=False)


class ARAP_PT_stiffness(ArapSubPanel, bpy.types.Panel):
    bl_label = "Stiffness"
    bl_order = 40
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = arap_object(context)
        settings = obj.arap
        entries, index = settings.stiffness, settings.active_stiffness_index
        row = layout.row()
        n_rows = min(4, max(2, len(entries)))
        row.template_list(
            "ARAP_UL_stiffness", "", settings, "stiffness", settings, "active_stiffness_index", rows=n_rows
        )
        row.column().operator("arap.stiffness_remove", text="", icon="REMOVE")
        entry = entries[index] if index < len(entries) else None
        if entry is not None:
            column = split_column(layout)
            column.prop_search(entry, "name", obj, "vertex_groups", text="Group")
            if not entry.use_rigid:
                column.prop(entry, "factor", slider=True)
            column.prop(entry, "use_rigid")
            if entry.use_rigid:
                column.prop(entry, "use_single_body")
            _draw_group_buttons(context, layout, obj, entry.name)
        column = layout.column(align=True)
        column.operator("arap.stiffness_add", text="Make Rigid", icon="MESH_ICOSPHERE").use_rigid = True
        column.operator("arap.stiffness_add", icon="MOD_ARMATURE")


def _draw_control(
    context: bpy.types.Context, layout: bpy.types.UILayout, obj: bpy.types.Object, control: ArapControl
) -> None:
    column = split_column(layout)
    if not control.is_pin:
        column.prop(control, "target")
        if control.target is not None and control.target.type == "ARMATURE":
            column.prop_search(control, "bone", control.target.data, "bones")
    if control.kind != "bone":
        column.prop_search(control, "vertex_group", obj, "vertex_groups", text="Group")
        if not control.is_pin and settings_of(obj).has_radius:
            column.prop(control, "use_exact")
        _draw_group_buttons(context, layout, obj, control.vertex_group)
    problem = _problem_of(obj, control)
    if problem:
        draw_text(context, layout, problem, "ERROR")


def _problem_of(obj: bpy.types.Object, control: ArapControl) -> str:
    """Why an enabled control cannot work, '' if it can."""
    return control_problem(obj, control, with_weights=not is_following(obj)) if control.is_enabled else ""


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
    return "no weights" if not is_following(obj) and ui_cache.is_empty_group(obj, group) else ""


def _draw_group_buttons(
    context: bpy.types.Context, layout: bpy.types.UILayout, obj: bpy.types.Object, vertex_group: str
) -> None:
    """Paint, select, soften the group of the chosen entry."""
    row = button_row(context, layout, NARROW_FOR_THREE)
    row.enabled = vertex_group in obj.vertex_groups
    for operator, text, is_pressed in (
        ("arap.group_paint", "Paint", is_painted(obj, vertex_group)),
        ("arap.group_select", "Select", False),
        ("arap.group_soften", "Soften", False),
    ):
        row.operator(operator, text=text, depress=is_pressed).vertex_group = vertex_group
