# SPDX-License-Identifier: GPL-3.0-or-later
"""An operator that works off a job: progress in the status bar, Esc takes all back, one step of undo."""

from __future__ import annotations

from typing import Any

import bpy

from .. import api
from .common import tag_panels

STEP_TIME_LIMIT_S = 0.1  # the window is drawn, and Esc is seen, this often


class JobOperator:
    """To be mixed into an operator, whose execute() returns what work_off() returns."""

    act = "Bake"  # for messages

    _job: api.ShapesJob[Any]
    _timer: Any
    report: Any  # of the operator

    def report_result(self, job: Any, result: Any) -> None:
        """Says what has been made."""
        raise NotImplementedError

    def work_off(self, context: bpy.types.Context, job: api.ShapesJob[Any]) -> set[str]:
        """Does the job: at once without a window, else in steps from here on."""
        if bpy.app.background or context.window is None:
            self.report_result(job, api.run_job(job))
            return {"FINISHED"}
        self._job = job
        self._timer = context.window_manager.event_timer_add(0.01, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        # Nothing is let through: the frame and the keys are the job's until it is done.
        if event.type == "ESC" and event.value == "PRESS":
            self._cancel(context)
            self.report({"WARNING"}, f"{self.act} cancelled: nothing has changed")
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            if self._job.step(STEP_TIME_LIMIT_S):
                context.workspace.status_text_set(f"ARAP {self.act}: {self._job.status}   |   Esc: cancel")
                return {"RUNNING_MODAL"}
            result = self._job.finish()
        except Exception as error:  # noqa: BLE001 - all or nothing, whatever went wrong
            self._cancel(context)
            self.report({"ERROR"}, f"{self.act} failed and nothing has changed: {error}")
            return {"CANCELLED"}
        self._leave(context)
        self.report_result(self._job, result)
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
