# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Handles: objects and bones that move vertices."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty

from ..ui.checks import (
    allow,
    find_posed_object,
    one_step,
    posed_object,
    reports_errors,
    selected_vertices,
    why_not_changeable,
    why_not_object_mode,
)
from .handles import add_handle, add_handles_for, remove_handle

Target = tuple[bpy.types.Object, str]  # the name of the bone is '' for a whole object


def selected_targets(context: bpy.types.Context, obj: bpy.types.Object) -> list[Target]:
    """What is selected and not a handle of the mesh yet: bones in Pose Mode, else empties."""
    if context.mode == "POSE":
        targets = [(bone.id_data, bone.name) for bone in context.selected_pose_bones]
    else:
        targets = [(other, "") for other in context.selected_objects if other.type == "EMPTY"]
    taken = {(handle.target, handle.bone) for handle in obj.arap.handles}
    return [target for target in targets if target not in taken]


def why_not_edited(context: bpy.types.Context) -> str:
    """As why_not_changeable(), and it must be in Edit Mode."""
    reason = why_not_changeable(context)
    if reason or posed_object(context).mode == "EDIT":
        return reason
    return "Select vertices in Edit Mode (Tab) to hang them on a handle"


def why_no_handles(context: bpy.types.Context) -> str:
    """As why_not_changeable(), and it must have handles."""
    reason = why_not_changeable(context)
    if reason or posed_object(context).arap.handles:
        return reason
    return "Add a handle first: nothing moves the mesh yet"


class ARAP_OT_handle_add(bpy.types.Operator):
    bl_idname = "arap.handle_add"
    bl_label = "Add ARAP Handle"
    bl_description = "Hang the selected vertices on a new empty: move, turn or scale it while posing and they follow"
    bl_options = {"REGISTER"}

    name: StringProperty(name="Name", description="Name of the new handle and its empty", default="Handle")
    is_exact: BoolProperty(
        name="Exact",
        description="Hold every vertex, even where the handle is smaller than Rigidity, which pulls a spike",
        default=False,
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_edited(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        vertices = selected_vertices(obj, "No vertices are selected: select those that the handle shall move")
        with one_step(obj, self.bl_label):
            add_handle(obj, vertices, name=self.name, is_exact=self.is_exact)
        return {"FINISHED"}


class ARAP_OT_handle_add_from_empties(bpy.types.Operator):
    bl_idname = "arap.handle_add_from_empties"
    bl_label = "Add ARAP Handles from Selected Empties"
    bl_description = "Each selected empty (in Pose Mode: each selected bone) takes the vertices around it"
    bl_options = {"REGISTER", "UNDO"}

    radius: FloatProperty(
        name="Radius",
        description=(
            "Take the vertices within this distance, in scene units, or the nearest one where there is none. "
            "0: the nearest"
        ),
        default=0.0,
        min=0.0,
        subtype="DISTANCE",
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        reason = why_not_changeable(context)
        obj = find_posed_object(context)
        if not reason and obj is not None:
            reason = why_not_object_mode(obj)
            if not reason and not selected_targets(context, obj):
                reason = "Select empties (in Pose Mode: bones) that are not handles yet, with the mesh"
        return allow(cls, reason)

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        add_handles_for(obj, selected_targets(context, obj), radius=self.radius or None)
        return {"FINISHED"}


class ARAP_OT_handle_remove(bpy.types.Operator):
    bl_idname = "arap.handle_remove"
    bl_label = "Remove ARAP Handle"
    bl_description = "Remove the handle chosen in the list, with the empty and the vertex group that were made for it"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_handles(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        with one_step(obj, self.bl_label):
            remove_handle(obj, obj.arap.active_handle_index)
        return {"FINISHED"}


CLASSES = (
    ARAP_OT_handle_add,
    ARAP_OT_handle_add_from_empties,
    ARAP_OT_handle_remove,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
