# SPDX-License-Identifier: GPL-3.0-or-later
"""Work in steps, so that an operator can show progress and take Esc between them."""

from __future__ import annotations

from types import GenericAlias
from typing import Any, Generic, Protocol, TypeVar

from .background import Background, Cancelled, Progress, Steps

STEP_S = 0.1  # default length of a step

Result = TypeVar("Result")
Result_co = TypeVar("Result_co", covariant=True)


class Job(Protocol[Result_co]):
    """If step() or finish() raises, call cancel(): it brings everything back."""

    noun: str
    """For messages, for example 'bake'."""

    @property
    def uid(self) -> int:
        """The session_uid of the mesh."""

    @property
    def object_name(self) -> str:
        """Of the mesh, for messages."""

    @property
    def fraction(self) -> float:
        """Done so far, 0 to 1."""

    @property
    def stage_fraction(self) -> float:
        """Done of what ``status`` tells, 0 to 1."""

    @property
    def status(self) -> str:
        """What is being done, for the status bar."""

    def step(self, time_limit_s: float = STEP_S) -> bool:
        """Works for about ``time_limit_s``. True while there is more to do."""

    def finish(self) -> Result_co:
        """Writes the result, once step() has returned False."""

    def cancel(self) -> None:
        """Everything as before."""


class BackgroundJob(Generic[Result]):
    """The base of Jobs that do all their work in the background, before finish().

    It begins with the first step(): of many jobs that are checked before any work, one works at a time.
    """

    __class_getitem__: Any = classmethod(GenericAlias)  # see Background

    def __init__(self, steps: Steps[Result]) -> None:
        self._todo = steps
        self._work: Background[Result] | None = None

    @property
    def fraction(self) -> float:
        return 0.0 if self._work is None else self._work.fraction

    @property
    def stage_fraction(self) -> float:
        return self.fraction

    def step(self, time_limit_s: float = STEP_S) -> bool:
        """Waits for up to ``time_limit_s``; True while there is more to do. After the last step, call finish()."""
        if self._work is None:
            self._work = Background(self._todo)
        return self._work.step(time_limit_s)

    def cancel(self) -> None:
        self._todo.close()
        if self._work is not None:
            self._work.drop()

    def _result(self) -> Result:
        """What the work has returned; raises what it has raised. After the last step."""
        assert self._work is not None
        return self._work.result()


def run_job(job: Job[Result_co], progress: Progress | None = None) -> Result_co:
    """All steps of a job; returns and raises as its step() and finish().

    Raises:
        Cancelled: ``progress`` returned False; nothing has changed.
    """
    try:
        while job.step():
            if progress is not None and progress(job.fraction) is False:
                raise Cancelled(f"The {job.noun} of '{job.object_name}' was cancelled; nothing has changed")
        return job.finish()
    except BaseException:
        job.cancel()
        raise
