# SPDX-License-Identifier: GPL-3.0-or-later
"""Solving without the posing act, with or without a window."""

from __future__ import annotations

import bpy

from ..core.session_data import Readout
from ..scene import redraw
from ..ui.checks import allow, posed_object, reports_errors, why_not_solvable
from . import solve
from .job_operator import JobOperator
from .solve import SolveJob, begin_solve


def solve_with_progress(context: bpy.types.Context, obj: bpy.types.Object) -> Readout:
    """As solve(), with the progress at the cursor: for acts whose redo panel solves again at every change."""
    windows = context.window_manager
    windows.progress_begin(0, 100)
    try:
        readout = solve.solve(
            obj,
            context.evaluated_depsgraph_get(),
            progress=lambda fraction: windows.progress_update(100 * fraction),
        )
    finally:
        windows.progress_end()
    redraw.tag_panels()
    return readout


def unsettled_text(readout: Readout) -> str:
    """What there is to say where a solve has not converged; '' where it has."""
    if readout.stop_reason == "converged":
        return ""
    text = "Stopped after {}, before the accuracy was reached: allow more under Settings, At Most"
    return text.format(_iterations_text(readout))


def _iterations_text(readout: Readout) -> str:
    n = readout.iterations
    return "1 iteration" if n == 1 else f"{n} iterations"


class ARAP_OT_solve(JobOperator, bpy.types.Operator):
    bl_idname = "arap.solve"
    bl_label = "ARAP Solve"
    bl_description = "Pose the mesh for the handles where they are now, to the end. Starts from the rest shape"
    bl_options = {"UNDO"}

    act = "Solve"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_solvable(context))

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> set[str]:
        return self._begin(context)

    @reports_errors
    def _begin(self, context: bpy.types.Context) -> set[str]:
        return self.work_off(context, begin_solve(posed_object(context), context.evaluated_depsgraph_get()))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        """For scripts: done when it returns."""
        self.report_result(None, solve.solve(posed_object(context), context.evaluated_depsgraph_get()))
        redraw.tag_panels()
        return {"FINISHED"}

    def report_result(self, _job: SolveJob | None, readout: Readout) -> None:
        unsettled = unsettled_text(readout)
        if unsettled:
            self.report({"WARNING"}, unsettled)
        else:
            text = f"Solved in {_iterations_text(readout)}, {readout.last_ms:.0f} ms"
            self.report({"INFO"}, text)


def register() -> None:
    bpy.utils.register_class(ARAP_OT_solve)


def unregister() -> None:
    bpy.utils.unregister_class(ARAP_OT_solve)
