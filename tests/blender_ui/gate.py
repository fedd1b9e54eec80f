# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds the add-on's work until a test has looked at it: no test needs a mesh that keeps a fast machine busy."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch

SMALL_STEP_S = 1e-4


class Gate:
    """Closed until open() is called. ``is_holding``: some work has arrived and waits."""

    def __init__(self) -> None:
        self._is_open = False
        self.is_holding = False

    def open(self) -> None:
        self._is_open = True

    def hold(self) -> bool:
        """For work that asks again: whether it must not go on."""
        self.is_holding = not self._is_open
        return self.is_holding


@contextmanager
def held_stage(stage_class: Any, *, after: float) -> Iterator[Gate]:
    """Holds work in the background (a bind, Solve) in its first stage that ends beyond the fraction ``after``.

    The job of that stage goes on to its end; the work does not hear of that.
    """
    gate = Gate()
    wait = stage_class.wait

    def held_wait(stage: Any, time_limit_s: float) -> bool:
        return not (stage.end > after and gate.hold()) and bool(wait(stage, time_limit_s))

    with patch.object(stage_class, "wait", held_wait):
        yield gate


@contextmanager
def held_shapes(job_class: Any) -> Iterator[Gate]:
    """Holds a job of many shapes (a bake, an export) once the first one is solved."""
    gate = Gate()
    step = job_class.step

    def held_step(job: Any, _time_limit_s: float) -> bool:
        return (job.fraction > 0.0 and gate.hold()) or bool(step(job, SMALL_STEP_S))

    with patch.object(job_class, "step", held_step):
        yield gate


@contextmanager
def held_settling(tracker_class: Any) -> Iterator[Gate]:
    """Lets meshes follow their handles, but not settle."""
    gate = Gate()
    take = tracker_class._take

    def unsettled_take(tracker: Any, stats: Any) -> None:
        take(tracker, stats)
        tracker.is_settled = False

    def held_refine(_tracker: Any, _time_limit_s: float) -> None:
        gate.hold()

    with patch.multiple(tracker_class, _take=unsettled_take, refine=held_refine):
        yield gate
