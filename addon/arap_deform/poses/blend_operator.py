# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Applying and blending stored poses: both move the handles, and the mesh follows."""

from collections.abc import Callable

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from ..core.native import sentence_of
from ..follow.runs import clear_follow_error
from ..pose.result import capture_transforms, restore_transforms
from ..pose.solve import solve_with_progress, unsettled_text
from ..scene import redraw
from ..ui.checks import ArapOperator, arap_object, reports_errors
from ..ui.modal import ModalOperator
from ..ui.panels import split_column
from .blend_run import BlendRun
from .library import NOW, REST, Placement, apply_pose, blend_poses
from .operators import active_name, is_followed, why_not_applicable

STARTS = (
    ("NOW", "Handles Now", "From the present places of the handles"),
    ("REST", "Rest", "From the places of the handles at rest"),
    ("POSE", "Stored Pose", "From another stored pose"),
)


class PoseOperator(ArapOperator):
    """A mixin for operators that move the handles. The mesh follows; if it cannot, the handles go back."""

    why_not = staticmethod(why_not_applicable)

    report: Callable[[set[str], str], None]

    def place(self, context: bpy.types.Context, obj: bpy.types.Object) -> Placement:
        """Moves the handles."""
        raise NotImplementedError

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        """Moves the handles, and solves unless Pose or Follow does so."""
        clear_follow_error(obj)
        before = capture_transforms(obj)
        try:
            placement = self.place(context, obj)
            unsettled = "" if is_followed(obj) else unsettled_text(solve_with_progress(context, obj))
        except BaseException:
            restore_transforms(before)
            raise
        for text in (str(placement), unsettled):
            if text:
                self.report({"WARNING"}, text)
        redraw.tag_panels()


class ARAP_OT_poses_apply(PoseOperator, bpy.types.Operator):
    bl_idname = "arap.poses_apply"
    bl_label = "Apply Stored Pose"
    bl_description = "Move the handles to their places in the pose. The mesh follows"

    pose: StringProperty(
        name="Pose", description="The pose to apply. Empty = the selected pose of the list", options={"SKIP_SAVE"}
    )

    def draw(self, context: bpy.types.Context) -> None:
        self.layout.prop_search(self, "pose", arap_object(context).arap, "poses")

    def place(self, context: bpy.types.Context, obj: bpy.types.Object) -> Placement:
        self.pose = self.pose or active_name(context)
        return apply_pose(obj, self.pose)


class ARAP_OT_poses_blend(ModalOperator, PoseOperator, bpy.types.Operator):
    bl_idname = "arap.poses_blend"
    bl_label = "Blend Poses"
    bl_description = (
        "Move the handles to places between two poses. Drag to the right, then click. "
        "You can change the factor in the panel that appears"
    )
    bl_options = {"REGISTER", "UNDO", "GRAB_CURSOR_X", "BLOCKING"}

    start: EnumProperty(name="From", description="The pose at factor 0", items=STARTS, default="NOW")
    start_pose: StringProperty(name="From Pose", description="The stored pose at factor 0", options={"SKIP_SAVE"})
    pose: StringProperty(
        name="To", description="The pose at factor 1. Empty = the selected pose of the list", options={"SKIP_SAVE"}
    )
    factor: FloatProperty(
        name="Factor",
        description="0 = the first pose, 1 = the second. Larger values go on beyond the second",
        default=0.5,
        min=-1.0,
        max=2.0,
        soft_min=0.0,
        soft_max=1.0,
        precision=3,
    )

    _run: BlendRun
    _is_confirmed: bool

    def draw(self, context: bpy.types.Context) -> None:
        layout = split_column(self.layout)
        settings = arap_object(context).arap
        layout.prop(self, "start")
        if self.start == "POSE":
            layout.prop_search(self, "start_pose", settings, "poses")
        layout.prop_search(self, "pose", settings, "poses")
        layout.prop(self, "factor", slider=True)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return self._begin(context, event)

    @reports_errors
    def _begin(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self._choose(context)
        obj = arap_object(context)
        self._run = BlendRun(context, obj, self._blend, event.mouse_x, is_followed=is_followed(obj))
        self._is_confirmed = False
        self.factor = 0.0
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self._report(self._run.abort())
            return {"CANCELLED"}
        try:
            if event.type == "TIMER":
                if self._run.tick():
                    redraw.tag_views()
                if self._is_confirmed and self._run.is_ready:
                    return self._keep(context)
            elif event.type == "MOUSEMOVE" and not self._is_confirmed:
                self.factor = self._run.factor_at(event.mouse_x)
                self._run.set_factor(self.factor)
            elif event.type in {"LEFTMOUSE", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
                self._is_confirmed = True
        except Exception as error:  # noqa: BLE001 - all or nothing, whatever went wrong
            problem = self._run.abort()
            text = sentence_of(error)
            self._report(f"{text}. {problem}" if problem else f"Nothing has changed: {text}")
            return {"CANCELLED"}
        self._show(context)
        # The timer of an interaction must go on.
        return {"PASS_THROUGH"} if event.type == "TIMER" else {"RUNNING_MODAL"}

    def place(self, context: bpy.types.Context, obj: bpy.types.Object) -> Placement:
        self._choose(context)
        return self._blend(obj, self.factor)

    def _keep(self, context: bpy.types.Context) -> set[str]:
        """As execute() from the start, so that the redo panel gives the same result for this factor."""
        self._run.end()
        self._run.restore_handles()
        result = self.execute(context)
        if "FINISHED" not in result:
            self._report(self._run.restore())
        return result

    def _report(self, problem: str) -> None:
        if problem:
            self.report({"ERROR"}, problem)

    def _choose(self, context: bpy.types.Context) -> None:
        self.pose = self.pose or active_name(context)
        self.start_pose = self.start_pose or self.pose

    def _blend(self, obj: bpy.types.Object, factor: float) -> Placement:
        start = {"NOW": NOW, "REST": REST}.get(self.start, self.start_pose)
        return blend_poses(obj, start, self.pose, factor)

    def _show(self, context: bpy.types.Context) -> None:
        keys = "Left or right: less or more   |   Click, Enter: keep   |   Esc: cancel"
        self._run.show_status(context, f"{self.factor:.0%} of the way to '{self.pose}'   |   {keys}")
