# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Baking: the pose to a shape key, the animation of the handles to keyframed shape keys."""

from typing import Any

import bpy
from bpy.props import IntProperty, StringProperty

from .. import api
from .common import allow, posed_object, reports_errors, tag_panels, why_no_pose, why_not_solvable

STEP_TIME_LIMIT_S = 0.1  # the window is drawn, and Esc is seen, this often


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
        self.report({"INFO"}, f"Baked to shape key '{key.name}'")
        return {"FINISHED"}


class ARAP_OT_bake_animation(bpy.types.Operator):
    bl_idname = "arap.bake_animation"
    bl_label = "ARAP Bake Animation"
    bl_description = "Solve each frame and make it a keyframed shape key, so that the file plays without this add-on"
    bl_options = {"UNDO"}  # not REGISTER: its redo panel would bake again at every change

    frame_start: IntProperty(name="Start", description="First frame to bake", default=1)
    frame_end: IntProperty(name="End", description="Last frame to bake, always included", default=250)
    frame_step: IntProperty(
        name="Step", description="Bake every so many frames; those in between are blended", default=1, min=1
    )

    _job: api.BakeJob
    _timer: Any

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
        layout.label(text=text, icon=icon)

    @property
    def _range(self) -> tuple[int, int, int]:
        return self.frame_start, self.frame_end, self.frame_step

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        if bpy.app.background or context.window is None:
            job = api.begin_bake(obj, *self._range)
            self._report_keys(api.run_bake(job), job.n_unsettled)
            return {"FINISHED"}
        self._job = api.begin_bake(obj, *self._range)
        self._timer = context.window_manager.event_timer_add(0.01, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        # Nothing is let through: the frame and the key are the bake's until it is done.
        if event.type == "ESC" and event.value == "PRESS":
            self._cancel(context)
            self.report({"WARNING"}, "Bake cancelled: nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            if self._job.step(STEP_TIME_LIMIT_S):
                self._show(context)
                return {"RUNNING_MODAL"}
            names = self._job.finish()
        except Exception as error:  # noqa: BLE001 - all or nothing, whatever went wrong
            self._cancel(context)
            self.report({"ERROR"}, f"Bake failed and nothing has changed: {error}")
            return {"CANCELLED"}
        self._leave(context)
        self._report_keys(names, self._job.n_unsettled)
        return {"FINISHED"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator: file load, closed window, or Esc in the dialog, where there is no job yet."""
        if hasattr(self, "_job"):
            self._cancel(context)

    def _cancel(self, context: bpy.types.Context) -> None:
        try:
            self._job.cancel()
        finally:
            self._leave(context)

    def _leave(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.workspace.status_text_set(None)
        tag_panels(context)

    def _show(self, context: bpy.types.Context) -> None:
        job = self._job
        if job.bind_fraction is None:
            state = f"frame {job.frame}, {job.fraction:.0%} done"
        else:
            state = f"preparing the mesh, {job.bind_fraction:.0%}"
        context.workspace.status_text_set(f"ARAP Bake: {state}   |   Esc: cancel")

    def _report_keys(self, names: list[str], n_unsettled: int) -> None:
        self.report({"INFO"}, f"Baked {len(names)} shape keys, '{names[0]}' to '{names[-1]}'")
        if n_unsettled:
            self.report(
                {"WARNING"},
                f"{n_unsettled} of {len(names)} frames stopped before the tolerance was met: "
                "allow more under Settings, At Most",
            )


CLASSES = (ARAP_OT_bake_pose, ARAP_OT_bake_animation)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
