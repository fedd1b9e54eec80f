# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Make Stand-in: the selected meshes are posed as one. And Remove Stand-in."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import IntProperty

from ..core.naming import listed
from ..engine.scene import is_rendering
from ..pose.job_operator import JobOperator
from ..ui.checks import ArapOperator, arap_object, select_alone, why_not_idle, why_not_object_mode
from .operators import KINDS
from .stand_in import StandInJob, remove_stand_in, stand_in_of
from .stand_in_parts import VERTICES, pieces_of, why_needless, why_not_local


def selected_shapes(context: bpy.types.Context) -> list[bpy.types.Object]:
    """What is selected and has a shape, but for stand-ins."""
    return [obj for obj in context.selected_objects if obj.type in KINDS and not obj.arap.is_stand_in]


def why_not_together(context: bpy.types.Context) -> str:
    """Why the selected meshes cannot be posed together, '' if they can."""
    if context.mode != "OBJECT":
        return why_not_object_mode(context.object)
    pieces = pieces_of(selected_shapes(context))
    reason = why_needless(pieces, VERTICES) or ("Wait until the render ends" if is_rendering() else "")
    return reason or next(filter(None, map(why_not_local, pieces)), "")


class ARAP_OT_stand_in_make(JobOperator, bpy.types.Operator):
    bl_idname = "arap.stand_in_make"
    bl_label = "Make Stand-in"
    bl_description = (
        "Pose the selected meshes as one solid: figures in pieces, sculpts of many subtools. They are attached to a "
        "mesh that stands for them"
    )
    bl_options = {"REGISTER", "UNDO"}
    task_name = "Make Stand-in"
    why_not = staticmethod(why_not_together)
    ends_itself = True

    vertices: IntProperty(
        name="Vertices",
        description=(
            "Vertices of the stand-in, about. If the meshes have more, the stand-in is coarser than they are: it is "
            "light, and they keep their detail"
        ),
        default=VERTICES,
        min=100,
        soft_min=10_000,
        soft_max=1_000_000,
    )

    def chosen(self, context: bpy.types.Context) -> bpy.types.Object | None:
        return next(iter(selected_shapes(context)), None)

    def begin(self, context: bpy.types.Context, _obj: bpy.types.Object) -> StandInJob:
        return StandInJob(selected_shapes(context), self.vertices)

    def result_text(self, job: Any, stand_in: Any) -> str:
        n = len(stand_in.data.vertices)
        left = f". Attached to their own hosts as before: {listed(job.left)}" if job.left else ""
        return f"'{stand_in.name}' has {n:,} vertices: pose it, or pull any of the meshes{left}"

    def report_result(self, job: Any, stand_in: Any) -> None:
        select_alone(bpy.context, stand_in)
        super().report_result(job, stand_in)


def why_no_stand_in(context: bpy.types.Context) -> str:
    """As why_not_idle(). The mesh must be a stand-in, or attached to one."""
    reason = why_not_idle(context)
    if reason or stand_in_of(arap_object(context)) is not None:
        return reason
    return "Select a stand-in first, or a mesh that is attached to one"


class ARAP_OT_stand_in_remove(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.stand_in_remove"
    bl_label = "Remove Stand-in"
    bl_description = (
        "Remove the stand-in with its pose and handles. The meshes go back to rest, without the shape keys made for it"
    )
    why_not = staticmethod(why_no_stand_in)

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        stand_in = stand_in_of(obj)
        if stand_in is None:
            raise ValueError(why_no_stand_in(context))
        parts = [attachment.object for attachment in stand_in.arap.attachments if attachment.object is not None]
        remove_stand_in(stand_in)
        shown = [part for part in parts if part.visible_get()]
        for part in shown:
            part.select_set(True)
        if shown:
            context.view_layer.objects.active = shown[0]
