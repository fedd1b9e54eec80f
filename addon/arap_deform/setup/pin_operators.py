# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Pins: vertex groups that stay where they are."""

import bpy
from bpy.props import StringProperty

from ..ui.checks import allow, one_step, posed_object, reports_errors, selected_vertices, why_not_changeable
from .pins import add_pin, add_pin_group, remove_pin


def why_nothing_to_pin(context: bpy.types.Context) -> str:
    """As why_not_changeable(), and it must be in Edit Mode or have vertex groups."""
    reason = why_not_changeable(context)
    if reason or posed_object(context).mode == "EDIT" or posed_object(context).vertex_groups:
        return reason
    return "Select vertices in Edit Mode (Tab) to pin them"


class ARAP_OT_pin_add(bpy.types.Operator):
    bl_idname = "arap.pin_add"
    bl_label = "Add ARAP Pin"
    bl_description = "Hold vertices where they are. In Edit Mode: the selected vertices. Otherwise: a vertex group"
    bl_options = {"REGISTER"}

    name: StringProperty(name="Name", description="Name of the new pin", default="Pin")
    vertex_group: StringProperty(
        name="Vertex Group", description="Group to pin, outside of Edit Mode", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_nothing_to_pin(context))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        obj = posed_object(context)
        if obj.mode == "EDIT" or self.vertex_group:
            return self.execute(context)
        if obj.vertex_groups.active is not None:
            self.vertex_group = obj.vertex_groups.active.name
        return set(context.window_manager.invoke_props_dialog(self))

    def draw(self, context: bpy.types.Context) -> None:
        obj = posed_object(context)
        if obj.mode == "EDIT":
            self.layout.prop(self, "name")
        else:
            self.layout.prop_search(self, "vertex_group", obj, "vertex_groups")

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        if obj.mode == "EDIT":
            vertices = selected_vertices(obj, "No vertices are selected: select those to hold")
            with one_step(obj, self.bl_label):
                add_pin(obj, vertices, name=self.name)
        elif not self.vertex_group:
            raise ValueError("Choose the vertex group to pin, or select vertices in Edit Mode")
        else:
            with one_step(obj, self.bl_label):
                add_pin_group(obj, self.vertex_group)
        return {"FINISHED"}


class ARAP_OT_pin_remove(bpy.types.Operator):
    bl_idname = "arap.pin_remove"
    bl_label = "Remove ARAP Pin"
    bl_description = "Let the vertices of the pin chosen in the list go"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        reason = why_not_changeable(context)
        if not reason and not posed_object(context).arap.pins:
            reason = "Add a pin first: nothing is pinned yet"
        return allow(cls, reason)

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        with one_step(obj, self.bl_label):
            remove_pin(obj, obj.arap.active_pin_index)
        return {"FINISHED"}


CLASSES = (ARAP_OT_pin_add, ARAP_OT_pin_remove)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
