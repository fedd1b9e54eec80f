# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Baking: the pose to a shape key, the animation of the handles to keyframed shape keys."""

import bpy
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty

from ..pose.job_operator import ShapesJobOperator
from ..pose.result import bake_pose
from ..scene import mesh_size, versions
from ..ui.checks import allow, posed_object, reports_errors, why_no_pose, why_not_solvable
from .keys import BakeJob, begin_bake, estimate_bake


class ARAP_OT_bake_pose(bpy.types.Operator):
    bl_idname = "arap.bake_pose"
    bl_label = "Bake ARAP Pose"
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
        key = bake_pose(posed_object(context), name=self.name)
        self.report({"INFO"}, f"Baked to shape key '{key.name}'")
        return {"FINISHED"}


class ARAP_OT_bake_animation(ShapesJobOperator, bpy.types.Operator):
    bl_idname = "arap.bake_animation"
    bl_label = "Bake ARAP Animation"
    bl_description = "Solve each frame and make it a keyframed shape key, so that the file plays without this add-on"
    bl_options = {"UNDO"}  # not REGISTER: its redo panel would bake again at every change

    frame_start: IntProperty(name="Start", description="First frame to bake", default=1)
    frame_end: IntProperty(name="End", description="Last frame to bake, always included", default=250)
    frame_step: IntProperty(
        name="Step", description="Solve every so many frames; those in between are blended", default=1, min=1
    )
    use_fewest_keys: BoolProperty(
        name="Fewest Keys",
        description="Make only as few shape keys as keep every vertex near to where it is in each solved frame",
        default=False,
    )
    fewest_keys_percent: FloatProperty(
        name="Within",
        description=(
            "How far a vertex may be from where it is in a solved frame, in percent of the mesh's size "
            "(the diagonal of its box at rest). Every vertex of every solved frame is checked"
        ),
        default=0.1,
        min=0.0,
        max=100.0,
        soft_max=5.0,
        precision=3,
        step=1,
        subtype="PERCENTAGE",
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
        column = layout.column(align=True)
        column.prop(self, "use_fewest_keys")
        within = column.column()
        within.active = self.use_fewest_keys
        within.prop(self, "fewest_keys_percent")
        try:
            text = str(estimate_bake(posed_object(context), *self._range))
            text = f"At most {text}" if self.use_fewest_keys else text
            icon = "SHAPEKEY_DATA"
            if self.use_fewest_keys:
                bound = f"Off by at most {self._tolerance_text(context)}"
                layout.label(text=bound, translate=False, icon="DRIVER_DISTANCE")
        except (ValueError, RuntimeError) as error:
            text, icon = str(error), "ERROR"
        layout.label(text=text, translate=False, icon=icon)

    @property
    def _range(self) -> tuple[int, int, int]:
        return self.frame_start, self.frame_end, self.frame_step

    def _tolerance_text(self, context: bpy.types.Context) -> str:
        size = mesh_size.diagonal(posed_object(context), context.evaluated_depsgraph_get())
        return versions.length_text(context.scene, size * self.fewest_keys_percent / 100.0)

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        percent = self.fewest_keys_percent if self.use_fewest_keys else None
        job = begin_bake(posed_object(context), *self._range, fewest_keys_percent=percent)
        return self.work_off(context, job)

    def report_shapes(self, job: BakeJob, names: list[str]) -> None:
        text = "Baked shape keys '{}' to '{}': {}"
        self.report({"INFO"}, text.format(names[0], names[-1], job.fit))


CLASSES = (ARAP_OT_bake_pose, ARAP_OT_bake_animation)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
