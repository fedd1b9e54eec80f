# SPDX-License-Identifier: GPL-3.0-or-later
"""Back to rest: handles, mesh, or what counts as rest."""

from __future__ import annotations

import bpy

from ..scene.placing import reset_handles
from ..setup.handle_operators import why_no_handles
from ..ui.checks import allow, posed_object, reports_errors, why_no_pose, why_no_reset
from .result import apply_pose_as_rest, reset_pose


class ARAP_OT_reset_handles(bpy.types.Operator):
    bl_idname = "arap.reset_handles"
    bl_label = "Reset ARAP Handles"
    bl_description = "Put every handle back to where it is while the mesh is at rest"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_handles(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        held = reset_handles(posed_object(context))
        if held:
            text = "Animation, a constraint or a driver holds these handles: {}"
            self.report({"WARNING"}, text.format(", ".join(held)))
        return {"FINISHED"}


class ARAP_OT_reset_pose(bpy.types.Operator):
    bl_idname = "arap.reset_pose"
    bl_label = "Reset ARAP Pose"
    bl_description = "Put the mesh back to its rest shape; the handles stay where they are"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_reset(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        reset_pose(posed_object(context))
        return {"FINISHED"}


class ARAP_OT_apply_pose_as_rest(bpy.types.Operator):
    bl_idname = "arap.apply_pose_as_rest"
    bl_label = "Apply ARAP Pose as Rest"
    bl_description = "Make the pose shown the new rest shape of the mesh; the handles are at rest where they stand"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_pose(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        apply_pose_as_rest(posed_object(context))
        return {"FINISHED"}


CLASSES = (ARAP_OT_reset_handles, ARAP_OT_reset_pose, ARAP_OT_apply_pose_as_rest)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
