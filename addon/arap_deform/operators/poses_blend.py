# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Stored poses: applying and blending them, which moves the handles and lets the mesh come after them."""

from collections.abc import Callable

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from .. import api
from ..api_result import capture_transforms, restore_transforms
from .blend_run import BlendRun
from .common import StatusBar, allow, posed_object, reports_errors, tag_panels, tag_views
from .poses import active_name, is_followed, why_not_applicable

STARTS = (
    ("NOW", "Handles Now", "From where the handles are"),
    ("REST", "Rest", "From the handles at rest"),
    ("POSE", "Stored Pose", "From another stored pose"),
)


class PoseOperator:
    """To be mixed into operators that move the handles: the mesh comes after them, all or nothing."""

    report: Callable[[set[str], str], None]

    def place(self, context: bpy.types.Context, act: Callable[[bpy.types.Object], api.Placement]) -> set[str]:
        """Moves the handles by ``act`` and solves, where nothing else does."""
        obj = posed_object(context)
        before = capture_transforms(obj)
        try:
            placement = act(obj)
            unsettled = "" if is_followed(obj) else _solve(context, obj)
        except BaseException:
            restore_transforms(before)
            raise
        for text in (str(placement), unsettled):
            if text:
                self.report({"WARNING"}, text)
        tag_panels(context)
        return {"FINISHED"}


class ARAP_OT_poses_apply(PoseOperator, bpy.types.Operator):
    bl_idname = "arap.poses_apply"
    bl_label = "Apply Stored ARAP Pose"
    bl_description = "Move the handles to where they were in the pose, and the mesh after them"
    bl_options = {"REGISTER", "UNDO"}

    pose: StringProperty(
        name="Pose", description="The pose to apply; empty: the one chosen in the list", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_applicable(context))

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop_search(self, "pose", posed_object(context).arap, "poses")

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        self.pose = self.pose or active_name(context)
        return self.place(context, lambda obj: api.apply_pose(obj, self.pose))


class ARAP_OT_poses_blend(PoseOperator, bpy.types.Operator):
    bl_idname = "arap.poses_blend"
    bl_label = "Blend ARAP Poses"
    bl_description = (
        "Move the handles to between two poses and solve: rotations turn the short way, and nothing is bent that need "
        "not be. Move the mouse to the right, then click; the panel that appears has the factor too"
    )
    bl_options = {"REGISTER", "UNDO", "GRAB_CURSOR_X", "BLOCKING"}

    start: EnumProperty(name="From", description="The pose at factor 0", items=STARTS, default="NOW")
    start_pose: StringProperty(name="From Pose", description="The stored pose at factor 0", options={"SKIP_SAVE"})
    pose: StringProperty(
        name="To", description="The pose at factor 1; empty: the one chosen in the list", options={"SKIP_SAVE"}
    )
    factor: FloatProperty(
        name="Factor",
        description="How far from the first pose to the second: 0 is the first, 1 the second, beyond it goes on",
        default=0.5,
        min=-1.0,
        max=2.0,
        soft_min=0.0,
        soft_max=1.0,
        precision=3,
    )

    _run: BlendRun
    _status: StatusBar
    _is_confirmed: bool

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_applicable(context))

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        settings = posed_object(context).arap
        layout.prop(self, "start")
        if self.start == "POSE":
            layout.prop_search(self, "start_pose", settings, "poses")
        layout.prop_search(self, "pose", settings, "poses")
        layout.prop(self, "factor", slider=True)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self._choose(context)
        obj = posed_object(context)
        try:
            self._run = BlendRun(context, obj, self._blend, event.mouse_x, is_followed=is_followed(obj))
        except (ValueError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._status = StatusBar()
        self._is_confirmed = False
        self.factor = 0.0
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self.cancel(context)
            return {"CANCELLED"}
        try:
            if event.type == "TIMER":
                if self._run.tick():
                    tag_views(context)
                if self._is_confirmed and self._run.is_ready:
                    return self._keep(context)
            elif event.type == "MOUSEMOVE" and not self._is_confirmed:
                self.factor = self._run.factor_at(event.mouse_x)
                self._run.set_factor(self.factor)
            elif event.type in {"LEFTMOUSE", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
                self._is_confirmed = True
        except Exception as error:  # noqa: BLE001 - all or nothing, whatever went wrong
            self.cancel(context)
            self.report({"ERROR"}, f"Nothing has changed: {error}")
            return {"CANCELLED"}
        self._show(context)
        # The timer of a posing act goes on, too.
        return {"PASS_THROUGH"} if event.type == "TIMER" else {"RUNNING_MODAL"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator, or Esc."""
        self._run.end(context)
        self._status.clear()
        self._run.restore()
        tag_panels(context)

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        self._choose(context)
        return self.place(context, lambda obj: self._blend(obj, self.factor))

    def _keep(self, context: bpy.types.Context) -> set[str]:
        """As execute() from the start: what is kept is what the panel of the last act gives for this factor."""
        self._run.end(context)
        self._status.clear()
        self._run.restore_handles()
        result = self.execute(context)
        if "FINISHED" not in result:
            self._run.restore()
        return result

    def _choose(self, context: bpy.types.Context) -> None:
        self.pose = self.pose or active_name(context)
        self.start_pose = self.start_pose or self.pose

    def _blend(self, obj: bpy.types.Object, factor: float) -> api.Placement:
        start = {"NOW": api.NOW, "REST": api.REST}.get(self.start, self.start_pose)
        return api.blend_poses(obj, start, self.pose, factor)

    def _show(self, context: bpy.types.Context) -> None:
        run = self._run
        state = "" if run.is_ready else f"preparing the mesh, {run.bind_fraction:.0%}   |   "
        self._status.show(
            context,
            f"ARAP Blend: {state}{self.factor:.0%} of the way to '{self.pose}'   |   "
            "Left or right: less or more   |   Click, Enter: keep   |   Esc: cancel",
        )


def _solve(context: bpy.types.Context, obj: bpy.types.Object) -> str:
    """Solves with the progress at the mouse; returns what there is to say where that has not converged."""
    windows = context.window_manager
    windows.progress_begin(0, 100)
    try:
        readout = api.solve(obj, progress=lambda fraction: windows.progress_update(100 * fraction))
    finally:
        windows.progress_end()
    if readout.stop_reason == "converged":
        return ""
    return (
        f"Stopped after {readout.iterations} iterations, before the tolerance was met: allow more in Settings, At Most"
    )


CLASSES = (ARAP_OT_poses_apply, ARAP_OT_poses_blend)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
