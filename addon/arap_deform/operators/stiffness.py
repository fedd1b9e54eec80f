# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Stiffness: vertex groups that bend less than the rest, or not at all."""

from typing import Any

import bpy
from bpy.props import BoolProperty, StringProperty

from .. import api, mesh_io
from .common import allow, find_posed_object, one_step, posed_object, reports_errors, why_no_mesh


def why_not_rigid(context: bpy.types.Context) -> str:
    """As why_no_mesh(), and vertices must be selected."""
    reason = why_no_mesh(context)
    obj = find_posed_object(context)
    if reason or obj is None:
        return reason
    if obj.mode != "EDIT":
        return "Select vertices in Edit Mode (Tab) to make them rigid"
    return "" if obj.data.total_vert_sel else "Select the vertices that shall keep their shape first"


class ARAP_OT_stiffness_add(bpy.types.Operator):
    bl_idname = "arap.stiffness_add"
    bl_label = "Add ARAP Stiffness"
    bl_description = (
        "Make vertices stiffer than the rest. In Edit Mode: the selected vertices. "
        "Otherwise: a vertex group, or a new one to paint"
    )
    bl_options = {"REGISTER"}

    name: StringProperty(name="Name", description="Name of the new entry and its vertex group", default="Stiff")
    vertex_group: StringProperty(
        name="Vertex Group",
        description="Group to stiffen, outside of Edit Mode; none: a new one, to be painted",
        options={"SKIP_SAVE"},
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_mesh(context))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        obj = posed_object(context)
        if obj.mode == "OBJECT" and obj.vertex_groups and not self.vertex_group:
            return set(context.window_manager.invoke_props_dialog(self))
        return self.execute(context)

    def draw(self, context: bpy.types.Context) -> None:
        obj = posed_object(context)
        if obj.mode != "EDIT":
            self.layout.prop_search(self, "vertex_group", obj, "vertex_groups")
        if not self.vertex_group:
            self.layout.prop(self, "name")

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        vertices = _selected(obj, "select those to stiffen") if obj.mode == "EDIT" else None
        with one_step(obj, self.bl_label):
            if vertices is not None:
                api.add_stiffness(obj, vertices, name=self.name)
            elif self.vertex_group:
                api.add_stiffness_group(obj, self.vertex_group)
            else:
                api.add_stiffness_group(obj, obj.vertex_groups.new(name=self.name).name).has_made_group = True
        return {"FINISHED"}


class ARAP_OT_rigid_add(bpy.types.Operator):
    bl_idname = "arap.rigid_add"
    bl_label = "Make ARAP Rigid"
    bl_description = (
        "The selected vertices keep their shape, as a helmet or a shoe does. Each connected piece moves as one body"
    )
    bl_options = {"REGISTER"}

    name: StringProperty(name="Name", description="Name of the new entry and its vertex group", default="Rigid")
    is_one_body: BoolProperty(
        name="One Body",
        description="All of it moves as one body, also pieces that are not joined: a helmet of several shells",
        default=False,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_rigid(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        vertices = _selected(obj, "select those that shall keep their shape")
        with one_step(obj, self.bl_label):
            api.add_rigid(obj, vertices, name=self.name, is_one_body=self.is_one_body)
        return {"FINISHED"}


class ARAP_OT_stiffness_remove(bpy.types.Operator):
    bl_idname = "arap.stiffness_remove"
    bl_label = "Remove ARAP Stiffness"
    bl_description = "Make the group chosen in the list as soft as the rest again"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        reason = why_no_mesh(context)
        return allow(
            cls, reason or ("" if posed_object(context).arap.stiffness else "Nothing is stiffer than the rest")
        )

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        with one_step(obj, self.bl_label):
            api.remove_stiffness(obj, obj.arap.active_stiffness_index)
        return {"FINISHED"}


def _selected(obj: bpy.types.Object, what: str) -> Any:
    vertices = mesh_io.selected_vertices(obj)
    if not len(vertices):
        raise ValueError(f"No vertices are selected: {what}")
    return vertices


CLASSES = (ARAP_OT_stiffness_add, ARAP_OT_rigid_add, ARAP_OT_stiffness_remove)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
