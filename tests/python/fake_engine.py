# SPDX-License-Identifier: GPL-3.0-or-later
"""What the fakes of the scenes that follow handles share."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from arap_deform.core.session_data import SolveStats


def stats(stop_reason: str = "max_iterations", iterations: int = 4) -> SolveStats:
    return SolveStats(
        vertices=8, free_vertices=4, last_ms=1.0, iterations=iterations, energy=0.0, energy_before=0.0, step=0.0,
        stop_reason=stop_reason, parts_at_rest=0, loose_vertices=0, outside=(), bind_ms=0.0, factor_ms=0.0,
    )  # fmt: skip


@dataclass
class FakeBind:
    """Makes its scene fit once it is adopted."""

    scene: Any
    fraction: float = 0.5
    is_done: bool = False
    is_dropped: bool = False
    n_steps: int = 0
    needs_s: float = 1.0
    error: Exception | None = None

    def step(self, time_limit_s: float) -> bool:
        self.n_steps += 1
        self.is_done = self.is_done or time_limit_s >= self.needs_s
        return not self.is_done

    def drop(self) -> None:
        self.is_dropped = True

    def adopt(self) -> None:
        if self.error is not None:
            raise self.error
        self.scene.is_fit = True
        self.scene.is_other = True


@dataclass
class FakeEngineScene:
    """Counts what is done with it. ``place`` is the place of its one handle."""

    is_fit: bool = True
    is_painted: bool = False
    n_settled: int = 0
    place: float = 0.0
    needed_updates: int = 1
    limit: int = 200
    error: Exception | None = None
    calls: list[str] = field(default_factory=list)
    limits: list[tuple[int | None, float | None]] = field(default_factory=list)  # of iterations, of seconds
    binds: list[FakeBind] = field(default_factory=list)
    bind_needs_s: float = 1.0

    def look(self) -> str:
        return ""

    def has_to_wait(self) -> bool:
        return self.is_painted

    def is_bound(self) -> bool:
        return self.is_fit

    def begin_bind(self) -> FakeBind:
        self.binds.append(FakeBind(self, needs_s=self.bind_needs_s))
        return self.binds[-1]

    is_shown: bool = False  # the session has the pose that the key shows
    is_other: bool = False  # it was bound since the last update

    def go_on_from_shown(self) -> bool:
        self.calls.append("go on")
        return not self.is_shown

    def is_rebound(self) -> bool:
        return self.is_other

    def matrices(self) -> np.ndarray:
        matrix = np.eye(4)
        matrix[0, 3] = self.place
        return matrix[None]

    def update(self, _matrices: np.ndarray, iterations: int | None, time_limit_s: float | None) -> SolveStats:
        self.limits.append((iterations, time_limit_s))
        return self.solved("follow" if iterations is None else "refine")

    def update_from_rest(self, _matrices: np.ndarray, time_limit_s: float | None) -> SolveStats:
        self.limits.append((None, time_limit_s))
        return self.solved("from rest")

    def solved(self, call: str) -> SolveStats:
        if self.error is not None:
            raise self.error
        self.calls.append(call)
        self.is_other = False
        self.needed_updates -= 1
        return stats("max_iterations" if self.needed_updates > 0 else "converged")

    @property
    def iteration_limit(self) -> int:
        return self.limit

    def settled(self) -> None:
        self.n_settled += 1


def evaluate_with_matrices(scene: FakeEngineScene, handler: Callable[[], object], times: int = 1 << 30) -> None:
    """From now on, so many times, reading the handles evaluates the scene, which calls a handler."""
    plain = scene.matrices
    calls = iter(range(times))

    def matrices_that_evaluate() -> np.ndarray:
        if next(calls, None) is not None:
            handler()
        return plain()

    scene.matrices = matrices_that_evaluate  # type: ignore[method-assign]
