# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Pose, and what ends it; Solve; and the ways back to rest."""

from typing import Any

import bpy
from bpy.props import BoolProperty

from ..core import sessions
from ..core.naming import counted
from ..core.session_data import SolveStats
from ..engine.interaction import Ending, Interaction
from ..scene import redraw, undo_step
from ..scene.placing import reset_handles
from ..ui.checks import (
    ArapOperator,
    allow,
    arap_object,
    find_arap_object,
    is_posed,
    reports_errors,
    why_baked,
    why_no_pose,
    why_not_posable,
    why_nothing_posed,
)
from ..ui.modal import ModalOperator
from .job_operator import JobOperator
from .result import apply_pose_as_rest, reset_pose
from .run import PoseRun
from .solve import SolveJob, begin_solve, solve, unsettled_text

VIEW_EVENTS = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "NDOF_MOTION"}


class ARAP_OT_pose(ModalOperator, bpy.types.Operator):
    bl_idname = "arap.pose"
    bl_label = "Pose"
    bl_description = "Move, turn and scale the handles and the mesh follows. Enter keeps the pose, Esc cancels it"
    bl_options = {"UNDO"}

    _run: PoseRun

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        if bpy.app.background:
            return allow(cls, "Posing needs a window: use Solve")
        return allow(cls, why_not_posable(context))

    @reports_errors
    def _begin(self, context: bpy.types.Context) -> set[str]:
        self._run = PoseRun(context, arap_object(context))
        context.window_manager.modal_handler_add(self)
        self._run.show_status(context)
        redraw.tag_panels()
        return {"RUNNING_MODAL"}

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        return self._begin(context)

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Lets every event through but Enter and Esc."""
        run = self._run
        is_ours = False
        if event.type == "TIMER":
            run.tick(context)
        else:
            # The release that ends a drag of another operator reaches us too, so only a press counts. While the pose
            # is being kept, nothing but moves of the view may begin: the end would cut it off.
            is_ours = event.value == "PRESS" and (
                self._on_press(context, event) or (run.interaction.is_keeping and event.type not in VIEW_EVENTS)
            )
            run.show_status(context)
        if run.interaction.end is None:
            return {"RUNNING_MODAL"} if is_ours else {"PASS_THROUGH"}
        end = run.finish()
        if end.message:
            self.report({"WARNING"} if end.error is None else {"ERROR"}, end.message)
        if end.how is Ending.KEEP:
            return {"FINISHED"}
        if end.how is Ending.RESTORE:
            undo_step.push("Cancel ARAP Pose")
        return {"CANCELLED"}

    def _on_press(self, context: bpy.types.Context, event: bpy.types.Event) -> bool:
        """Acts on our keys; True if the key was ours."""
        interaction = self._run.interaction
        if _editor_at(context, event) != "VIEW_3D":
            return False  # other editors have uses of their own for both keys
        if event.type in {"RET", "NUMPAD_ENTER"}:
            interaction.keep()
            return True
        if event.type == "ESC" and not context.screen.is_animation_playing:  # then Esc ends the playback
            interaction.cancel()
            return True
        return False


def _editor_at(context: bpy.types.Context, event: bpy.types.Event) -> str:
    for area in context.window.screen.areas:
        if area.x <= event.mouse_x < area.x + area.width and area.y <= event.mouse_y < area.y + area.height:
            return str(area.type)
    return ""


class ARAP_OT_pose_end(bpy.types.Operator):
    bl_idname = "arap.pose_end"
    bl_label = "End Pose"
    bl_description = "End posing: keep the pose, or put everything back to where it was before"

    is_kept: BoolProperty(name="Keep", description="Keep the pose. Off: put everything back", default=True)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = find_arap_object(context)
        return allow(cls, "" if obj is not None and is_posed(obj) else "Press Pose first: this mesh is not being posed")

    def execute(self, context: bpy.types.Context) -> set[str]:
        interaction = sessions.locks[arap_object(context).session_uid]
        assert isinstance(interaction, Interaction)
        if self.is_kept:
            interaction.keep()
        else:
            interaction.cancel()
        return {"FINISHED"}


class ARAP_OT_solve(JobOperator, bpy.types.Operator):
    bl_idname = "arap.solve"
    bl_label = "Solve"
    bl_description = "Pose the mesh for the present places of the handles, to convergence. Starts from the rest shape"
    why_not = staticmethod(why_not_posable)
    task_name = "Solve"

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        return super().execute(context)

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        """For scripts: the solve is done when it returns."""
        self.report_result(None, solve(arap_object(context), context.evaluated_depsgraph_get()))
        redraw.tag_panels()
        return {"FINISHED"}

    def begin(self, context: bpy.types.Context, obj: bpy.types.Object) -> SolveJob:
        return begin_solve(obj, context.evaluated_depsgraph_get())

    def report_result(self, _job: Any, stats: SolveStats) -> None:
        unsettled = unsettled_text(stats)
        if unsettled:
            self.report({"WARNING"}, unsettled)
        else:
            self.report({"INFO"}, f"Solved in {counted(stats.iterations, 'iteration')}, {stats.last_ms:.0f} ms")


class ARAP_OT_reset(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.reset"
    bl_label = "Reset"
    bl_description = "Put every handle back to its place at rest, and the mesh back to its rest shape"
    why_not = staticmethod(why_nothing_posed)

    def modify(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        held = reset_handles(obj) if obj.arap.handles else []
        if not obj.arap.use_follow and not sessions.locked_by(obj.session_uid) and not why_baked(obj):
            reset_pose(obj)
        if held:
            names = ", ".join(held)
            self.report({"WARNING"}, f"Animation, a constraint or a driver holds these handles: {names}")


class ARAP_OT_apply_pose_as_rest(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.apply_pose_as_rest"
    bl_label = "Apply Pose as Rest"
    bl_description = "Make the pose the new rest shape of the mesh. The present places of the handles become rest too"
    why_not = staticmethod(why_no_pose)

    def modify(self, _context: bpy.types.Context, obj: bpy.types.Object) -> None:
        apply_pose_as_rest(obj)
