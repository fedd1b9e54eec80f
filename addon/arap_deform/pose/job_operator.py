# SPDX-License-Identifier: GPL-3.0-or-later
"""An operator that does a job: progress in the views and in the status bar, Esc cancels, one step of undo."""

from __future__ import annotations

import time
from typing import Any

import bpy

from ..core.job import Job, run_job
from ..core.native import sentence_of
from ..follow.runs import clear_follow_error
from ..ui import waiting
from ..ui.checks import ArapOperator, arap_object, reports_errors
from ..ui.modal import ModalOperator, ModalRun
from ..ui.waits import Wait

TIMER_S = 0.01
STEP_TIME_LIMIT_S = 0.1  # the window is drawn, and Esc is seen, this often


class JobRun(ModalRun):
    """A job under way. Its owner calls abort(), or leave() after the job's end."""

    def __init__(self, context: bpy.types.Context, job: Job[Any], task_name: str) -> None:
        super().__init__(context, TIMER_S)
        self.job: Any = job
        self._act_name = task_name
        self._began = time.monotonic()
        waiting.watch(self)

    def wait(self) -> Wait | None:
        if self.has_left:
            return None
        text = f"{self._act_name}: {self.job.status}"
        return Wait(text, self.job.stage_fraction, time.monotonic() - self._began)

    def abort(self, _message: str = "") -> None:
        """Puts everything back."""
        try:
            self.job.cancel()
        finally:
            self.leave()


class JobOperator(ModalOperator, ArapOperator):
    """A mixin for operators that do the job which begin() makes."""

    bl_options = {"UNDO"}  # a long job has no REGISTER: the redo panel would do it again at every change
    task_name = "Bake"  # for messages

    report: Any  # of the operator
    options: bpy.types.OperatorOptions
    _run: JobRun

    def chosen(self, context: bpy.types.Context) -> bpy.types.Object:
        """The object that begin() takes."""
        return arap_object(context)

    def begin(self, context: bpy.types.Context, obj: bpy.types.Object) -> Job[Any]:
        raise NotImplementedError

    def result_text(self, job: Any, result: Any) -> str:
        """A sentence on the result of a job of shapes."""
        raise NotImplementedError

    def report_result(self, job: Any, result: Any) -> None:
        self.report({"INFO"}, self.result_text(job, result))
        if job.warning:
            self.report({"WARNING"}, job.warning)

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        """Does the job: in one call without a window or if Blender repeats it, else in steps of modal()."""
        obj = self.chosen(context)
        job = self.begin(context, obj)
        is_repeat = self.options.is_repeat or self.options.is_repeat_last
        if bpy.app.background or context.window is None or is_repeat:
            self.report_result(job, run_job(job))
            return {"FINISHED"}
        clear_follow_error(obj)
        self._run = JobRun(context, job, self.task_name)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        # No event is let through: until the job is done, mesh, frame and shape keys must not change.
        run = self._run
        if event.type == "ESC" and event.value == "PRESS":
            run.abort()
            self.report({"WARNING"}, f"{self.task_name} cancelled: nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            if run.job.step(STEP_TIME_LIMIT_S):
                run.show_text(context, f"ARAP {self.task_name}: {run.job.status}   |   Esc: cancel")
                return {"RUNNING_MODAL"}
            result = run.job.finish()
        except Exception as error:  # noqa: BLE001 - all or nothing, whatever went wrong
            run.abort()
            self.report({"ERROR"}, f"{self.task_name} failed and nothing has changed: {sentence_of(error)}")
            return {"CANCELLED"}
        run.leave()
        self.report_result(run.job, result)
        return {"FINISHED"}
