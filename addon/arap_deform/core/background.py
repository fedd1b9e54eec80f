# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that goes on in threads of the native module while Blender draws.

Long work is a generator. It yields a Stage for each job of the native module and goes on when that is done. What it
does in between, in Python, is short: that is done in the thread that asks for the next step.
"""

from __future__ import annotations

import contextlib
import math
import time
from collections.abc import Callable, Generator
from dataclasses import dataclass, replace
from types import GenericAlias
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

if TYPE_CHECKING:
    import arap_native

POLL_S = 0.05  # between two calls of ``progress``

Result = TypeVar("Result")
Progress = Callable[[float], "bool | None"]
"""Is called with the fraction done, 0 to 1; stops the work by returning False."""


class Cancelled(RuntimeError):
    """``progress`` stopped the work; everything is as it was before the call."""


@dataclass(frozen=True)
class Stage:
    """A job under way, and its share of the whole work: from the fraction ``start`` to ``end``.

    ``if_cancelled``: what is then said.
    """

    job: arap_native.Job[Any]
    if_cancelled: str
    start: float = 0.0
    end: float = 1.0

    @property
    def fraction(self) -> float:
        return self.start + self.job.fraction * (self.end - self.start)

    def wait(self, time_limit_s: float) -> bool:
        """Waits until the job is done, but no longer than that; returns whether it is."""
        return self.job.wait(time_limit_s)


Steps: TypeAlias = Generator[Stage, None, Result]


def stage(job: arap_native.Job[Result], if_cancelled: str) -> Steps[Result]:
    """A job as a stage; returns and raises as its result(). If the work is dropped, the job ends a little later."""
    try:
        yield Stage(job, if_cancelled)
    except GeneratorExit:
        job.cancel()
        raise
    return job.result()


def part(steps: Steps[Result], start: float, end: float) -> Steps[Result]:
    """The steps as a part of more work, from the fraction ``start`` to ``end`` of that."""
    scale = end - start
    with contextlib.closing(steps):
        while True:
            try:
                inner = next(steps)
            except StopIteration as stop:
                return stop.value  # type: ignore[no-any-return]
            yield replace(inner, start=start + scale * inner.start, end=start + scale * inner.end)


class Background(Generic[Result]):
    """Does the work of ``steps``, from now on. A timer calls step()."""

    # The module typing never forgets a class that was subscripted, and so keeps its module and bpy alive. If bpy is a
    # module of Python, Blender ends when bpy is freed. If it is never freed, Python ends Blender in the middle of its
    # work, and it hangs.
    __class_getitem__: Any = classmethod(GenericAlias)

    def __init__(self, steps: Steps[Result]) -> None:
        self._steps = steps
        self._stage: Stage | None = None
        self._fraction = 0.0
        self._result: Result | None = None
        self._error: BaseException | None = None
        self._go_on()

    @property
    def fraction(self) -> float:
        """Fraction done, 0 to 1."""
        return self._fraction if self._stage is None else self._stage.fraction

    @property
    def is_done(self) -> bool:
        """Whether the work has ended, in whatever way."""
        return self._stage is None

    def step(self, time_limit_s: float = 0.0) -> bool:
        """Works, but no longer than that; True while there is more to do."""
        end = time.monotonic() + time_limit_s
        while self._stage is not None and self._stage.wait(max(end - time.monotonic(), 0.0)):
            self._go_on()
        return not self.is_done

    def drop(self) -> None:
        """Ends the work, which then has no result. Does nothing if it has ended."""
        self._stage = None
        self._steps.close()

    def result(self) -> Result:
        """What ``steps`` returned; raises what they raised. Only when done."""
        if self._error is not None:
            raise self._error
        return self._result  # type: ignore[return-value]

    def run(self, progress: Progress | None) -> Result:
        """Does the work to its end and returns as result(); drops it if ``progress`` or Ctrl-C stops it."""
        try:
            while self._stage is not None:
                if progress is not None and progress(self.fraction) is False:
                    raise Cancelled(self._stage.if_cancelled)
                self.step(math.inf if progress is None else POLL_S)
        finally:
            self.drop()
        return self.result()

    def _go_on(self) -> None:
        """To the next stage, or the end."""
        self._fraction = self.fraction
        self._stage = None
        try:
            self._stage = next(self._steps)
        except StopIteration as stop:
            self._result = stop.value
            self._fraction = 1.0
        except BaseException as error:  # noqa: BLE001 - raised again by result()
            self._error = error


def run(steps: Steps[Result], progress: Progress | None = None) -> Result:
    """Does the work before it returns.

    Raises:
        As the steps. Cancelled: ``progress`` returned False.
    """
    return Background(steps).run(progress)
