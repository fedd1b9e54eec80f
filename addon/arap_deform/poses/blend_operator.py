# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Stored poses: applying and blending them, which moves the handles and lets the mesh come after them."""

from collections.abc import Callable

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from ..live import runs
from ..pose.result import capture_transforms, restore_transforms
from ..pose.solve_operator import solve_with_progress, unsettled_text
from ..scene import redraw
from ..ui.checks import allow, posed_object, reports_errors
from . import blend_run
from .blend_run import BlendRun
from .library import NOW, REST, Placement, apply_pose, blend_poses
from .operators import active_name, is_followed, why_not_applicable

STARTS = (
    ("NOW", "Handles Now", "From where the handles are"),
    ("REST", "Rest", "From the handles at rest"),
    ("POSE", "Stored Pose", "From another stored pose"),
)


class PoseOperator:
    """To be mixed into operators that move the handles: the mesh comes after them, all or nothing."""

    report: Callable[[set[str], str], None]

    def place(self, context: bpy.types.Context, act: Callable[[bpy.types.Object], Placement]) -> set[str]:
        """Moves the handles by ``act`` and solves, where nothing else does."""
        obj = posed_object(context)
        runs.give_up(obj)
        before = capture_transforms(obj)
        try:
            placement = act(obj)
            unsettled = "" if is_followed(obj) else unsettled_text(solve_with_progress(context, obj))
        except BaseException:
            restore_transforms(before)
            raise
        for text in (str(placement), unsettled):
            if text:
                self.report({"WARNING"}, text)
        redraw.tag_panels()
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
        return self.place(context, lambda obj: apply_pose(obj, self.pose))


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
        self._is_confirmed = False
        self.factor = 0.0
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            self._report(self._run.cancel())
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
            problem = self._run.cancel()
            reason = str(error)
            self._report(f"{reason}. {problem}" if problem else f"Nothing has changed: {reason}")
            return {"CANCELLED"}
        self._show(context)
        # The timer of a posing act goes on, too.
        return {"PASS_THROUGH"} if event.type == "TIMER" else {"RUNNING_MODAL"}

    def cancel(self, _context: bpy.types.Context) -> None:
        """Blender ends the operator: file load, closed window."""
        self._run.cancel()

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        self._choose(context)
        return self.place(context, lambda obj: self._blend(obj, self.factor))

    def _keep(self, context: bpy.types.Context) -> set[str]:
        """As execute() from the start: what is kept is what the panel of the last act gives for this factor."""
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
        run = self._run
        parts = [
            f"{self.factor:.0%} of the way to '{self.pose}'",
            "Left or right: less or more",
            "Click, Enter: keep",
            "Esc: cancel",
        ]
        if not run.is_ready:
            parts.insert(0, f"preparing the mesh, {run.bind_fraction:.0%}")
        run.show_status(context, f"{'ARAP Blend'}: {'   |   '.join(parts)}")


CLASSES = (ARAP_OT_poses_apply, ARAP_OT_poses_blend)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    blend_run.cancel_all()
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
