# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that takes a while, as a modal operator: done in steps, with its progress in the status bar, and Esc."""

from __future__ import annotations

from typing import Any, Protocol

import bpy

from .. import api, redraw
from ..texts import iface_, rpt_
from .common import StatusBar

TIMER_S = 0.01
STEP_TIME_LIMIT_S = 0.1  # the window is drawn, and Esc is seen, this often


class Job(Protocol):
    """What is done. Where step() raises, everything is brought back by cancel()."""

    @property
    def fraction(self) -> float:
        """Done so far, 0 to 1."""

    @property
    def status(self) -> str:
        """What is being done, translated."""

    def step(self, time_limit_s: float) -> bool:
        """Works for about so long; True while there is more to do."""

    def finish(self) -> Any:
        """Writes and returns the result, once step() has returned False."""

    def cancel(self) -> None:
        """Everything as before."""


class JobOperator:
    """For an operator that runs a job. Nothing else is let through: the mesh is the job's until it is done."""

    bl_label: str
    report: Any
    job: Any
    _timer: Any
    _status: StatusBar

    def report_result(self, job: Any, result: Any) -> None:
        """Says what has been made."""
        raise NotImplementedError

    def begin_job(self, context: bpy.types.Context, job: Job) -> set[str]:
        """For invoke() and execute(), in a window: does the job in steps from here on."""
        self.job = job
        self._status = StatusBar()
        self._timer = context.window_manager.event_timer_add(TIMER_S, window=context.window)
        context.window_manager.progress_begin(0, 100)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if event.type == "ESC" and event.value == "PRESS":
            self._cancel(context)
            self.report({"WARNING"}, rpt_("{} was cancelled: nothing has changed").format(rpt_(self.bl_label)))
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        try:
            if self.job.step(STEP_TIME_LIMIT_S):
                self._show(context)
                return {"RUNNING_MODAL"}
            result = self.job.finish()
        except Exception as error:  # noqa: BLE001 - all or nothing, whatever went wrong
            self._cancel(context)
            text = rpt_("{} failed and nothing has changed: {}")
            self.report({"ERROR"}, text.format(rpt_(self.bl_label), rpt_(str(error))))
            return {"CANCELLED"}
        self._leave(context)
        self.report_result(self.job, result)
        return {"FINISHED"}

    def cancel(self, context: bpy.types.Context) -> None:
        """Blender ends the operator: file load, closed window, or Esc in a dialog, where there is no job yet."""
        if hasattr(self, "job"):
            self._cancel(context)

    def _cancel(self, context: bpy.types.Context) -> None:
        try:
            self.job.cancel()
        finally:
            self._leave(context)

    def _leave(self, context: bpy.types.Context) -> None:
        context.window_manager.event_timer_remove(self._timer)
        context.window_manager.progress_end()
        self._status.clear()
        redraw.tag_panels()

    def _show(self, context: bpy.types.Context) -> None:
        context.window_manager.progress_update(100 * self.job.fraction)
        self._status.show(context, f"{iface_(self.bl_label)}: {self.job.status}   |   {iface_('Esc: cancel')}")


class ShapesJobOperator(JobOperator):
    """For one that solves many shapes."""

    def report_shapes(self, job: Any, result: Any) -> None:
        """Says what has been made of them."""
        raise NotImplementedError

    def work_off(self, context: bpy.types.Context, job: api.ShapesJob[Any]) -> set[str]:
        """For execute(): at once without a window, else in steps."""
        if bpy.app.background or context.window is None:
            self.report_result(job, api.run_job(job))
            return {"FINISHED"}
        return self.begin_job(context, job)

    def report_result(self, job: Any, result: Any) -> None:
        self.report_shapes(job, result)
        if job.n_unsettled:
            text = rpt_("{} of {} solves stopped before the tolerance was met: allow more under Settings, At Most")
            self.report({"WARNING"}, text.format(job.n_unsettled, job.n_shapes))
