# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds the add-on's work until a test has looked at it: no test needs a mesh that keeps a fast machine busy."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from unittest.mock import patch

SMALL_STEP_S = 1e-4


class Gate:
    """Closed until open() is called. ``is_holding``: some work has arrived and waits."""

    def __init__(self) -> None:
        self._is_open = False
        self._changed = threading.Condition()
        self.is_holding = False

    def open(self) -> None:
        self._is_open = True
        self.look_again()

    def look_again(self) -> None:
        """Lets go of a thread that need not wait any longer."""
        with self._changed:
            self._changed.notify_all()

    def wait(self, may_leave: Callable[[], bool]) -> None:
        """Holds the thread that calls it. It does not need Python meanwhile, so it cannot disturb Blender."""
        with self._changed:
            while not (self._is_open or may_leave()):
                self.is_holding = True
                self._changed.wait()
            self.is_holding = False

    def hold(self) -> bool:
        """For work in the main thread, which asks again: whether it must not go on."""
        self.is_holding = not self._is_open
        return self.is_holding


@contextmanager
def held_thread(binding_class: Any, *, after: float, holds_dropped: bool) -> Iterator[Gate]:
    """Holds work in a thread (a bind, Solve) in its first progress call beyond the fraction ``after``.

    Work that is dropped goes on, and so ends; with ``holds_dropped`` only once the gate is open.
    """
    gate = Gate()
    progress, drop = binding_class._progress, binding_class.drop

    def held_progress(binding: Any, fraction: float) -> bool:
        progress(binding, fraction)  # so that the test sees the fraction
        if fraction > after:
            gate.wait(lambda: binding._is_dropped and not holds_dropped)
        return bool(progress(binding, fraction))

    def heard_drop(binding: Any) -> None:
        drop(binding)
        gate.look_again()

    with patch.multiple(binding_class, _progress=held_progress, drop=heard_drop):
        try:
            yield gate
        finally:
            gate.open()


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
def held_settling(follower_class: Any) -> Iterator[Gate]:
    """Lets meshes follow their handles, but not settle."""
    gate = Gate()
    take = follower_class._take

    def unsettled_take(follower: Any, readout: Any) -> None:
        take(follower, readout)
        follower.is_settled = False

    def held_refine(_follower: Any, _time_limit_s: float) -> None:
        gate.hold()

    with patch.multiple(follower_class, _take=unsettled_take, refine=held_refine):
        yield gate
