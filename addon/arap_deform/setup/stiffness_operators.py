# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Stiffness: vertex groups that bend less than the rest, or not at all."""

import bpy
from bpy.props import BoolProperty, StringProperty

from ..scene import meshes
from ..ui.checks import allow, one_step, posed_object, reports_errors, selected_vertices, why_not_changeable
from .stiffness import add_rigid, add_stiffness, add_stiffness_group, remove_stiffness


def why_not_rigid(context: bpy.types.Context) -> str:
    """As why_not_changeable(), and vertices must be selected."""
    reason = why_not_changeable(context)
    if reason:
        return reason
    obj = posed_object(context)
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
        return allow(cls, why_not_changeable(context))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        obj = posed_object(context)
        if obj.mode == "OBJECT" and obj.vertex_groups and not self.vertex_group:
            active = obj.vertex_groups.active
            if active is not None and active.name not in obj.arap.stiffness:  # what is stiff already is not meant
                self.vertex_group = active.name
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
        if obj.mode == "EDIT":
            vertices = selected_vertices(obj, "No vertices are selected: select those to stiffen")
            with one_step(obj, self.bl_label):
                add_stiffness(obj, vertices, name=self.name)
            return {"FINISHED"}
        meshes.check_mesh(obj)  # before there is a group that nothing would use
        with one_step(obj, self.bl_label):
            if self.vertex_group:
                add_stiffness_group(obj, self.vertex_group)
            else:
                add_stiffness_group(obj, obj.vertex_groups.new(name=self.name).name).has_made_group = True
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
        vertices = selected_vertices(obj, "No vertices are selected: select those that shall keep their shape")
        with one_step(obj, self.bl_label):
            add_rigid(obj, vertices, name=self.name, is_one_body=self.is_one_body)
        return {"FINISHED"}


class ARAP_OT_stiffness_remove(bpy.types.Operator):
    bl_idname = "arap.stiffness_remove"
    bl_label = "Remove ARAP Stiffness"
    bl_description = "Make the group chosen in the list as soft as the rest again"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        reason = why_not_changeable(context)
        if not reason and not posed_object(context).arap.stiffness:
            reason = "Add a stiff group first: nothing is stiffer than the rest yet"
        return allow(cls, reason)

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        with one_step(obj, self.bl_label):
            remove_stiffness(obj, obj.arap.active_stiffness_index)
        return {"FINISHED"}


CLASSES = (ARAP_OT_stiffness_add, ARAP_OT_rigid_add, ARAP_OT_stiffness_remove)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
