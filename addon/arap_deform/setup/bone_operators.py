# SPDX-License-Identifier: GPL-3.0-or-later
"""Add Bones: bones of an armature as handles without vertex groups."""

from __future__ import annotations

import bpy

from ..core.naming import listed
from ..ui.checks import ArapOperator, arap_object, why_not_changeable, why_not_object_mode
from .bones import add_bones
from .handles import following_first_handle


def selected_armatures(context: bpy.types.Context) -> list[bpy.types.Object]:
    return [other for other in context.selected_objects if other.type == "ARMATURE"]


def _chosen_bones(context: bpy.types.Context) -> tuple[bpy.types.Object | None, list[str]]:
    """In Pose Mode the active armature and its selected bones, else the selected armature and no bones."""
    if context.mode == "POSE":
        armature = context.object
        return armature, [bone.name for bone in context.selected_pose_bones if bone.id_data == armature]
    armatures = selected_armatures(context)
    return (armatures[0], []) if len(armatures) == 1 else (None, [])


def why_no_bones(context: bpy.types.Context) -> str:
    """As why_not_changeable(). The mesh must be in Object Mode, and an armature or bones of one must be selected."""
    reason = why_not_changeable(context) or why_not_object_mode(arap_object(context))
    if reason:
        return reason
    armature, bones = _chosen_bones(context)
    if armature is None or (context.mode == "POSE" and not bones):
        return "Select the mesh and an armature; in Pose Mode, the bones"
    return ""


class ARAP_OT_bones_add(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.bones_add"
    bl_label = "Add Bones"
    bl_description = (
        "Bones of the selected armature move what they pass through inside the mesh: no weights to paint. "
        "In Object Mode all that deform, in Pose Mode the selected ones. Sets Model to Solid"
    )
    why_not = staticmethod(why_no_bones)

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        armature, names = _chosen_bones(context)
        with following_first_handle(obj):
            added = add_bones(obj, armature, names)
        self.report({"INFO"}, f"Bones that move '{obj.name}': {listed(added)}. Pin what has no bone and should stay")
