# SPDX-License-Identifier: GPL-3.0-or-later
"""An operator that works off a job: progress in the status bar and at the mouse, Esc takes all back, one undo step."""

from __future__ import annotations

from typing import Any

import bpy

from ..core.job import Job, run_job
from ..live import runs
from ..scene import redraw
from ..ui.checks import StatusBar

TIMER_S = 0.01
STEP_TIME_LIMIT_S = 0.1  # the window is drawn, and Esc is seen, this often


class JobRun:
    """A job under way, and what it has put into Blender's window. Whoever ends it calls keep() or cancel()."""

    def __init__(self, context: bpy.types.Context, job: Any, act: str) -> None:
        self.job = job
        self._act = act
        self._status = StatusBar()
        self._timer = context.window_manager.event_timer_add(TIMER_S, window=context.window)
        context.window_manager.progress_begin(0, 100)
        _runs.append(self)

    def show(self, context: bpy.types.Context) -> None:
        """How far it is."""
        context.window_manager.progress_update(100 * self.job.fraction)
        text = "ARAP {}: {}   |   Esc: cancel"
        self._status.show(context, text.format(self._act, self.job.status))

    def cancel(self) -> None:
        """Everything as before the job."""
        try:
            self.job.cancel()
        finally:
            self.leave()

    def leave(self) -> None:
        """Gives the window free."""
        _runs.remove(self)
        bpy.context.window_manager.event_timer_remove(self._timer)
        bpy.context.window_manager.progress_end()
        self._status.clear()
        redraw.tag_panels()


_runs: list[JobRun] = []


class JobOperator:
    """To be mixed into an operator, whose execute() or invoke() returns what work_off() returns."""

    act = "Bake"  # for messages

    report: Any  # of the operator
    _run: JobRun

    def report_result(self, job: Any, result: Any) -> None:
        """Says what has been made."""
        raise NotImplementedError

    def work_off(self, context: bpy.types.Context, job: Job[Any]) -> set[str]:
        """Does the job: at once without a window, else in steps from here on."""
        if bpy.app.background or context.window is None:
            self.report_result(job, run_job(job))
            return {"FINISHED"}
        runs.give_up(bpy.data.objects[job.object_name])
        self._run = JobRun(context, job, self.act)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        # Nothing is let through: the mesh, the frame and the keys are the job's until it is done.
        run = self._run
        if event.type == "ESC" and event.value == "PRESS":
            run.cancel()
            self.report({"WARNING"}, f"{self.act} cancelled: nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            if run.job.step(STEP_TIME_LIMIT_S):
                run.show(context)
                return {"RUNNING_MODAL"}
            result = run.job.finish()
        except Exception as error:  # noqa: BLE001 - all or nothing, whatever went wrong
            run.cancel()
            text = "{} failed and nothing has changed: {}"
            self.report({"ERROR"}, text.format(self.act, str(error)))
            return {"CANCELLED"}
        run.leave()
        self.report_result(run.job, result)
        return {"FINISHED"}

    def cancel(self, _context: bpy.types.Context) -> None:
        """Blender ends the operator: file load, closed window, or Esc in the dialog, where there is no job yet."""
        if hasattr(self, "_run"):
            self._run.cancel()


class ShapesJobOperator(JobOperator):
    """For a job of many solves: says too how many of them stopped early."""

    def report_shapes(self, job: Any, result: Any) -> None:
        """Says what has been made of them."""
        raise NotImplementedError

    def report_result(self, job: Any, result: Any) -> None:
        self.report_shapes(job, result)
        if job.n_unsettled:
            text = "{} of {} solves stopped before the accuracy was reached: allow more under Settings, At Most"
            self.report({"WARNING"}, text.format(job.n_unsettled, job.n_shapes))


def register() -> None:
    """There is nothing to register."""


def unregister() -> None:
    for run in _runs.copy():  # Blender drops running operators without a word when their class goes
        run.cancel()
