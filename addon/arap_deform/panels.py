# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab "ARAP" in the sidebar of the 3D view."""

from __future__ import annotations

import textwrap
from typing import Any

import bpy

from . import api, compat, empty_groups, mesh_size
from .api_pose import settings_of
from .group_buttons import draw_group_buttons
from .operators.common import find_posed_object, posed_object
from .operators.pose_act import Phase, PoseAct, running

STOP_REASONS = {
    "converged": "Converged",
    "max_iterations": "Iteration limit",
    "time_limit": "Time limit",
    "cancelled": "Cancelled",
}


class ArapPanel:
    """What all panels of the tab share."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "ARAP"
    layout: bpy.types.UILayout


class ArapSubPanel(ArapPanel):
    """Shown once there is a mesh."""

    bl_parent_id = "ARAP_PT_main"
    bl_order = 2  # below those of other files that are about acts

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return find_posed_object(context) is not None


class ARAP_UL_pins(bpy.types.UIList):
    """Pins: on or off, and the vertex group."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: Any,
        pin: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        obj = find_posed_object(context)
        lack = "" if obj is None else lack_of_group(obj, pin.name)
        row = layout.row(align=True)
        row.prop(pin, "is_enabled", text="")
        label = row.row()
        label.active = pin.is_enabled
        label.alert = bool(lack)
        label.label(text=f"{pin.name} ({lack})" if lack else pin.name, icon="PINNED")


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


class ARAP_PT_main(ArapPanel, bpy.types.Panel):
    """State, the acts, and what the last solve did."""

    bl_idname = "ARAP_PT_main"
    bl_label = "ARAP Deform"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        problem = api.native_problem()
        if problem:
            draw_text(context, layout.box(), problem, "ERROR")
        obj = find_posed_object(context)
        if obj is None:
            draw_text(context, layout, "Select the mesh to pose.", "INFO")
            return
        layout.label(text=obj.name, icon="OUTLINER_OB_MESH")
        act = running.get(obj.name)
        if act is not None and not act.is_drag:
            _draw_act(context, layout, act)
        else:
            hint = _next_step(obj)
            if hint and not problem:
                draw_text(context, layout, hint, "INFO")
            _draw_buttons(layout)
        _draw_readout(layout, obj)


class ARAP_PT_handles(ArapSubPanel, bpy.types.Panel):
    """The list of handles."""

    bl_idname = "ARAP_PT_handles"
    bl_label = "Handles"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        settings = obj.arap
        row = layout.row()
        row.template_list("ARAP_UL_handles", "", settings, "handles", settings, "active_handle_index", rows=3)
        column = row.column(align=True)
        column.operator("arap.handle_add", text="", icon="ADD")
        column.operator("arap.handle_remove", text="", icon="REMOVE")
        if settings.active_handle_index < len(settings.handles):
            _draw_handle(context, layout, obj, settings.active_handle_index)
        column = layout.column(align=True)
        column.operator("arap.handle_add", text="Add from Selected Vertices", icon="VERTEXSEL")
        column.operator("arap.handle_add_from_empties", text="Add from Selected Empties", icon="EMPTY_AXIS")
        layout.operator("arap.reset_handles", text="Reset Handles", icon="LOOP_BACK")


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
        column.prop(settings, "handle_in_front")
        column.prop(settings, "handle_color")


class ARAP_PT_pins(ArapSubPanel, bpy.types.Panel):
    """The list of pins."""

    bl_idname = "ARAP_PT_pins"
    bl_label = "Pins"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        settings = obj.arap
        row = layout.row()
        row.template_list("ARAP_UL_pins", "", settings, "pins", settings, "active_pin_index", rows=3)
        column = row.column(align=True)
        column.operator("arap.pin_add", text="", icon="ADD")
        column.operator("arap.pin_remove", text="", icon="REMOVE")
        if settings.active_pin_index < len(settings.pins):
            pin = settings.pins[settings.active_pin_index]
            split_column(layout).prop_search(pin, "name", obj, "vertex_groups", text="Group")
            draw_group_buttons(layout, obj, pin.name)
        layout.operator(
            "arap.pin_add",
            text="Pin Selected Vertices" if obj.mode == "EDIT" else "Pin Vertex Group",
            icon="PINNED",
        )


class ARAP_PT_settings(ArapSubPanel, bpy.types.Panel):
    """What the solver does."""

    bl_idname = "ARAP_PT_settings"
    bl_label = "Settings"
    bl_order = 3  # below all lists
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        settings = obj.arap
        column = split_column(layout)
        key_name = column.row()
        key_name.enabled = obj.name not in running  # the pose under way is in that key
        key_name.prop(settings, "key_name")
        column.prop(settings, "energy")
        if settings_of(obj).has_radius:
            column.prop(settings, "rigidity")
            _draw_radius(context, column, obj)
        column.prop(settings, "weights")
        column.prop(settings, "initial_guess")
        column = split_column(layout)
        column.prop(settings, "iterations_per_update", text="Iterations")
        column.prop(settings, "max_iterations", text="At Most")
        column.prop(settings, "tolerance")
        column.prop(settings, "threads")
        column = split_column(layout)
        column.prop(settings, "join_seams")


def lack_of_group(obj: bpy.types.Object, group: str) -> str:
    """Why a pinned group holds nothing, '' where it does."""
    if group not in obj.vertex_groups:
        return "no such group"
    return "no weights" if not _is_following(obj) and empty_groups.is_empty(obj, group) else ""


def _next_step(obj: bpy.types.Object) -> str:
    """What somebody new does next; '' once everything is there."""
    settings = obj.arap
    if not settings.handles:
        if obj.mode != "EDIT":
            return "Press Tab, select the vertices to move, and add a handle below."
        return "Select the vertices to move, and add a handle below."
    if not settings.pins and len(settings.handles) < 2:
        return "Pin the vertices that shall stay, or the whole mesh moves with its handle."
    if obj.mode == "EDIT":
        return "Press Tab to leave Edit Mode, then Pose."
    return ""


def _draw_buttons(layout: bpy.types.UILayout) -> None:
    column = layout.column(align=True)
    pose = column.row(align=True)
    pose.scale_y = 1.6
    pose.operator("arap.pose", text="Pose", icon="PLAY")
    column.operator("arap.pull_tool", text="Pull", icon="VIEW_PAN")
    column.operator("arap.solve", text="Solve", icon="FILE_REFRESH")
    column = layout.column(align=True)
    column.operator("arap.bake_pose", text="Bake Pose", icon="SHAPEKEY_DATA")
    column.operator("arap.bake_animation", text="Bake Animation", icon="RENDER_ANIMATION")
    column = layout.column(align=True)
    column.operator("arap.reset_pose", text="Reset Pose", icon="LOOP_BACK")
    column.operator("arap.apply_pose_as_rest", text="Apply Pose as Rest", icon="CHECKMARK")


def _draw_act(context: bpy.types.Context, layout: bpy.types.UILayout, act: PoseAct) -> None:
    box = layout.box()
    if act.phase is Phase.BINDING:
        box.label(text=f"Preparing the mesh: {act.bind_fraction:.0%}", icon="SORTTIME")
    else:
        box.label(text="Settled" if act.is_settled else "Following the handles", icon="REC")
        draw_text(context, box, "Move, turn or scale a handle (G, R, S): the mesh follows.", "BLANK1")
    column = box.column(align=True)
    column.scale_y = 1.3
    column.operator("arap.pose_end", text="Keep (Enter)", icon="CHECKMARK").is_kept = True
    column.operator("arap.pose_end", text="Cancel (Esc)", icon="X").is_kept = False


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


def _draw_radius(context: bpy.types.Context, column: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """How long the radius is on this mesh, in the unit of the scene."""
    try:
        size = mesh_size.diagonal(obj, context.evaluated_depsgraph_get())
    except ValueError:  # scaled to nothing: posing says so
        return
    split = column.split(factor=0.4)
    name, value = split.row(), split.row()
    name.alignment = "RIGHT"
    name.label(text="Radius")
    value.label(text=compat.length_text(context.scene, size * obj.arap.rigidity / 100.0))


def _problem(obj: bpy.types.Object, index: int) -> str:
    """Why an enabled handle cannot work, '' if it can."""
    if not obj.arap.handles[index].is_enabled:
        return ""
    return api.handle_problem(obj, index, with_weights=not _is_following(obj))


def _is_following(obj: bpy.types.Object) -> bool:
    """Whether posing or Live has looked for what is wrong, and changes the mesh too often to look again."""
    return obj.name in running or bool(obj.arap.is_live)


def _draw_readout(layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    readout = api.readout(obj)
    if readout is None:
        return
    rows = [
        ("Vertices", f"{readout.vertices:,}"),
        ("Free", f"{readout.free_vertices:,}"),
        ("Last update", f"{readout.last_ms:.1f} ms"),
        ("Iterations", str(readout.iterations)),
        ("Energy", f"{readout.energy:.4g}"),
        ("Stopped", STOP_REASONS.get(readout.stop_reason, readout.stop_reason)),
    ]
    if readout.parts_at_rest:
        rows.append(("Parts at rest", f"{readout.parts_at_rest} (nothing holds them)"))
    if readout.loose_vertices:
        rows.append(("Loose vertices", f"{readout.loose_vertices:,}"))
    split = layout.box().split(factor=0.45)
    names, values = split.column(align=True), split.column(align=True)
    for name, value in rows:
        names.label(text=name)
        values.label(text=value)


def split_column(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def draw_text(context: bpy.types.Context, layout: bpy.types.UILayout, text: str, icon: str) -> None:
    """A sentence, wrapped to the width of the sidebar: labels do not wrap by themselves."""
    width = max(16, int((context.region.width / context.preferences.system.ui_scale - 60) / 6.2))
    column = layout.column(align=True)
    column.scale_y = 0.8
    for i, line in enumerate(textwrap.wrap(text, width)):
        column.label(text=line, icon=icon if i == 0 else "BLANK1")


CLASSES = (
    ARAP_UL_pins,
    ARAP_UL_handles,
    ARAP_PT_main,
    ARAP_PT_handles,
    ARAP_PT_handle_look,
    ARAP_PT_pins,
    ARAP_PT_settings,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
