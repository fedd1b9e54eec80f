# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Baking: the pose to a shape key, the animation of the handles to keyframed shape keys."""

import bpy
from bpy.props import IntProperty, StringProperty

from .. import api
from ..texts import rpt_
from .common import allow, posed_object, reports_errors, why_no_pose, why_not_solvable
from .job import JobOperator


class ARAP_OT_bake_pose(bpy.types.Operator):
    bl_idname = "arap.bake_pose"
    bl_label = "ARAP Bake Pose"
    bl_description = "Copy the pose shown to a new shape key with a name of its own"
    bl_options = {"REGISTER", "UNDO"}

    name: StringProperty(name="Name", description="Name of the new shape key", default="Pose")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_pose(context))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        return set(context.window_manager.invoke_props_dialog(self))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        key = api.bake_pose(posed_object(context), name=self.name)
        self.report({"INFO"}, rpt_("Baked to shape key '{}'").format(key.name))
        return {"FINISHED"}


class ARAP_OT_bake_animation(JobOperator, bpy.types.Operator):
    bl_idname = "arap.bake_animation"
    bl_label = "ARAP Bake Animation"
    bl_description = "Solve each frame and make it a keyframed shape key, so that the file plays without this add-on"
    bl_options = {"UNDO"}  # not REGISTER: its redo panel would bake again at every change

    frame_start: IntProperty(name="Start", description="First frame to bake", default=1)
    frame_end: IntProperty(name="End", description="Last frame to bake, always included", default=250)
    frame_step: IntProperty(
        name="Step", description="Bake every so many frames; those in between are blended", default=1, min=1
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_solvable(context))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        scene = context.scene
        if not self.properties.is_property_set("frame_start"):
            self.frame_start = scene.frame_start
        if not self.properties.is_property_set("frame_end"):
            self.frame_end = scene.frame_end
        return set(context.window_manager.invoke_props_dialog(self))

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column(align=True)
        column.prop(self, "frame_start")
        column.prop(self, "frame_end")
        column.prop(self, "frame_step")
        try:
            text, icon = str(api.estimate_bake(posed_object(context), *self._range)), "SHAPEKEY_DATA"
        except (ValueError, RuntimeError) as error:
            text, icon = str(error), "ERROR"
        layout.label(text=text, translate=False, icon=icon)

    @property
    def _range(self) -> tuple[int, int, int]:
        return self.frame_start, self.frame_end, self.frame_step

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        return self.work_off(context, api.begin_bake(posed_object(context), *self._range))

    def report_result(self, job: api.BakeJob, names: list[str]) -> None:
        text = rpt_("Baked {} shape keys, '{}' to '{}'")
        self.report({"INFO"}, text.format(len(names), names[0], names[-1]))
        if job.n_unsettled:
            text = rpt_("{} of {} frames stopped before the tolerance was met: allow more under Settings, At Most")
            self.report({"WARNING"}, text.format(job.n_unsettled, len(names)))


CLASSES = (ARAP_OT_bake_pose, ARAP_OT_bake_animation)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
