# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Stored poses: storing, mirroring, deleting them, and making shape keys of them; and what all that needs."""

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..pose.job_operator import ShapesJobOperator
from ..ui.checks import (
    allow,
    is_posed,
    posed_object,
    reports_errors,
    why_not_changeable,
    why_not_object_mode,
    why_not_solvable,
)
from .keys import PoseKeysJob, begin_pose_keys
from .library import delete_pose, mirror_pose, store_pose

AXES = (
    ("X", "X", "Left and right of the object's own plane X = 0"),
    ("Y", "Y", "In front of and behind the object's own plane Y = 0"),
    ("Z", "Z", "Above and below the object's own plane Z = 0"),
)


def why_no_library(context: bpy.types.Context) -> str:
    """As why_not_changeable(), and the mesh must be in Object Mode."""
    reason = why_not_changeable(context)
    return reason or why_not_object_mode(posed_object(context))


def why_not_storable(context: bpy.types.Context) -> str:
    """As why_no_library(), and there must be handles."""
    reason = why_no_library(context)
    if reason or posed_object(context).arap.handles:
        return reason
    return "Add a handle first: a pose is where the handles are"


def why_no_stored_pose(context: bpy.types.Context) -> str:
    """As why_no_library(), and there must be a stored pose."""
    return why_no_library(context) or ("" if posed_object(context).arap.poses else "Store a pose first")


def why_no_usable_pose(context: bpy.types.Context) -> str:
    """As why_not_storable() and why_no_stored_pose()."""
    return why_not_storable(context) or why_no_stored_pose(context)


def why_not_applicable(context: bpy.types.Context) -> str:
    """As why_no_usable_pose(), and the mesh must be able to follow."""
    reason = why_no_usable_pose(context)
    return reason or ("" if is_followed(posed_object(context)) else why_not_solvable(context))


def why_no_pose_keys(context: bpy.types.Context) -> str:
    """As why_no_usable_pose(), and the mesh must be idle and solvable."""
    return why_no_usable_pose(context) or why_not_solvable(context)


def is_followed(obj: bpy.types.Object) -> bool:
    """Whether the mesh follows its handles anyway: while it is posed, or live."""
    return is_posed(obj) or bool(obj.arap.is_live)


def active_name(context: bpy.types.Context) -> str:
    """Of the pose chosen in the list, '' where there is none."""
    settings = posed_object(context).arap
    index = settings.active_pose_index
    return str(settings.poses[index].name) if 0 <= index < len(settings.poses) else ""


class ARAP_OT_poses_store(bpy.types.Operator):
    bl_idname = "arap.poses_store"
    bl_label = "Store ARAP Pose"
    bl_description = "Add where the handles are now to the object's poses"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the pose, numbered where another has it", default="Pose")
    is_replacing: BoolProperty(
        name="Replace",
        description="Store into the pose chosen in the list, in place of what it has",
        default=False,
        options={"HIDDEN", "SKIP_SAVE"},
    )

    @classmethod
    def description(cls, _context: bpy.types.Context, properties: bpy.types.OperatorProperties) -> str:
        if properties.is_replacing:
            return "Store where the handles are now into the pose chosen in the list"
        return cls.bl_description

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_storable(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        name = active_name(context) if self.is_replacing else self.name
        if self.is_replacing and not name:
            raise ValueError("There is no pose to store into: choose one in the list")
        pose = store_pose(posed_object(context), name, replace=self.is_replacing)
        n = len(pose.motions)
        text = "Stored pose '{}' of 1 handle" if n == 1 else "Stored pose '{}' of {} handles"
        self.report({"INFO"}, text.format(pose.name, n))
        return {"FINISHED"}


class ARAP_OT_poses_delete(bpy.types.Operator):
    bl_idname = "arap.poses_delete"
    bl_label = "Delete ARAP Pose"
    bl_description = "Take the pose chosen in the list out of the library; handles, mesh and shape keys stay"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_stored_pose(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        delete_pose(posed_object(context), active_name(context))
        return {"FINISHED"}


class ARAP_OT_poses_mirror(bpy.types.Operator):
    bl_idname = "arap.poses_mirror"
    bl_label = "Mirror ARAP Pose"
    bl_description = (
        "Store the mirror image of the pose chosen in the list. Handles are paired by name (Hand.L and Hand.R), or by "
        "where they are at rest"
    )
    bl_options = {"REGISTER", "UNDO"}

    axis: EnumProperty(name="Axis", description="Across which plane of the object", items=AXES, default="X")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_usable_pose(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        pose = mirror_pose(posed_object(context), active_name(context), "XYZ".index(self.axis))
        self.report({"INFO"}, f"Stored pose '{pose.name}'")
        return {"FINISHED"}


class ARAP_OT_poses_to_keys(ShapesJobOperator, bpy.types.Operator):
    bl_idname = "arap.poses_to_keys"
    bl_label = "Make Shape Keys of ARAP Poses"
    bl_description = (
        "Solve every stored pose from rest and make it a shape key of its name, value 0. Keys made so before are "
        "renewed, all others stay as they are"
    )
    bl_options = {"UNDO"}  # not REGISTER: its redo panel would solve again at every change

    act = "Poses to Shape Keys"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_pose_keys(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.work_off(context, begin_pose_keys(posed_object(context)))

    def report_shapes(self, _job: PoseKeysJob, names: list[str]) -> None:
        text = "Made 1 shape key: {1}" if len(names) == 1 else "Made {0} shape keys: {1}"
        self.report({"INFO"}, text.format(len(names), ", ".join(names)))


CLASSES = (
    ARAP_OT_poses_store,
    ARAP_OT_poses_delete,
    ARAP_OT_poses_mirror,
    ARAP_OT_poses_to_keys,
)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
