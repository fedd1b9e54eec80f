# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Storing, mirroring and deleting poses, making shape keys of them; and the reasons why a task is not possible."""

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..core.naming import counted
from ..pose.job_operator import JobOperator
from ..ui.checks import (
    ArapOperator,
    arap_object,
    is_posed,
    why_not_changeable,
    why_not_object_mode,
    why_not_posable,
    why_not_solvable,
)
from .keys import PoseKeysJob
from .library import delete_pose, mirror_pose, store_pose

AXES = (
    ("X", "X", "Left and right: the object's plane X = 0"),
    ("Y", "Y", "Front and back: the object's plane Y = 0"),
    ("Z", "Z", "Top and bottom: the object's plane Z = 0"),
)


def why_no_library(context: bpy.types.Context) -> str:
    """As why_not_changeable(), and the mesh must be in Object Mode."""
    reason = why_not_changeable(context)
    return reason or why_not_object_mode(arap_object(context))


def why_not_storable(context: bpy.types.Context) -> str:
    """As why_no_library(), and there must be handles."""
    lack = "Add a handle first: a pose stores the places of the handles"
    return why_no_library(context) or ("" if arap_object(context).arap.handles else lack)


def why_no_stored_pose(context: bpy.types.Context) -> str:
    """As why_no_library(), and there must be a stored pose."""
    return why_no_library(context) or ("" if arap_object(context).arap.poses else "Store a pose first")


def why_no_usable_pose(context: bpy.types.Context) -> str:
    """As why_not_storable() and why_no_stored_pose()."""
    return why_not_storable(context) or why_no_stored_pose(context)


def why_not_applicable(context: bpy.types.Context) -> str:
    """As why_no_usable_pose(), and the mesh must be able to follow."""
    reason = why_no_usable_pose(context)
    return reason or ("" if is_followed(arap_object(context)) else why_not_posable(context))


def why_no_pose_keys(context: bpy.types.Context) -> str:
    """As why_no_usable_pose(), and the mesh must be idle and solvable."""
    return why_no_usable_pose(context) or why_not_solvable(context)


def is_followed(obj: bpy.types.Object) -> bool:
    """Whether Pose or Follow keeps the mesh to its handles."""
    return is_posed(obj) or bool(obj.arap.use_follow)


def active_name(context: bpy.types.Context) -> str:
    """The name of the selected pose of the list; '' if there is none."""
    settings = arap_object(context).arap
    index = settings.active_pose_index
    return str(settings.poses[index].name) if 0 <= index < len(settings.poses) else ""


class ARAP_OT_poses_store(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.poses_store"
    bl_label = "Store Pose"
    bl_description = "Add a pose with the present places of the handles"
    why_not = staticmethod(why_not_storable)

    name: StringProperty(
        name="Name", description="Name of the pose. A number is added if another pose has it", default="Pose"
    )
    is_replacing: BoolProperty(
        name="Replace",
        description="Replace the selected pose of the list",
        options={"HIDDEN", "SKIP_SAVE"},
    )

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        if properties.is_replacing:
            return "Replace the selected pose by the present places of the handles"
        return cls.bl_description

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        name = active_name(context) if self.is_replacing else self.name
        if self.is_replacing and not name:
            raise ValueError("No pose is selected: select one in the list")
        pose = store_pose(obj, name, replace=self.is_replacing)
        self.report({"INFO"}, f"Stored pose '{pose.name}' of {counted(len(pose.motions), 'handle')}")


class ARAP_OT_poses_delete(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.poses_delete"
    bl_label = "Delete Pose"
    bl_description = "Delete the selected pose of the list. Handles, mesh and shape keys stay"
    why_not = staticmethod(why_no_stored_pose)

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        delete_pose(obj, active_name(context))


class ARAP_OT_poses_mirror(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.poses_mirror"
    bl_label = "Mirror Pose"
    bl_description = (
        "Store the mirror image of the selected pose. Handles are paired by name (Hand.L and Hand.R), else by their "
        "places at rest"
    )
    why_not = staticmethod(why_no_usable_pose)

    axis: EnumProperty(name="Axis", description="Normal of the mirror plane, in object space", items=AXES, default="X")

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        pose = mirror_pose(obj, active_name(context), "XYZ".index(self.axis))
        self.report({"INFO"}, f"Stored pose '{pose.name}'")


class ARAP_OT_poses_to_keys(JobOperator, bpy.types.Operator):
    bl_idname = "arap.poses_to_keys"
    bl_label = "Poses to Shape Keys"
    bl_description = (
        "Solve every stored pose from rest and make it a shape key with the pose's name and value 0. Keys of earlier "
        "runs are replaced, other keys stay"
    )
    why_not = staticmethod(why_no_pose_keys)
    task_name = "Poses to Shape Keys"

    def begin(self, _context: bpy.types.Context, obj: bpy.types.Object) -> PoseKeysJob:
        return PoseKeysJob(obj)

    def result_text(self, _job: PoseKeysJob, names: list[str]) -> str:
        return f"Made {counted(len(names), 'shape key')}: {', '.join(names)}"
