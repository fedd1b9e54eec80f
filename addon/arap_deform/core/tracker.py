# SPDX-License-Identifier: GPL-3.0-or-later
"""How a mesh is kept to its handles: bind, follow, refine until settled. EngineScene stands for Blender.

The interaction, Pull and Follow share it. Each of them decides when it begins and ends.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .session_data import SolveStats

# An update may take this long while a handle moves: with the rest of a frame that gives about sixty frames a second.
# The solve gets what the checks and writing the key leave of it. It does at least one
# iteration, so a mesh that is too heavy for that still follows.
FOLLOW_TIME_LIMIT_S = 0.014
LEAST_TIME_LIMIT_S = 1e-4
# A refining step lets go of the window after this time, so that a heavy mesh does not make the mouse stutter.
REFINE_TIME_LIMIT_S = 0.05
# A step waits this long for a bind: a small mesh is then bound before anything is drawn.
BIND_STEP_S = 0.005


class Bind(Protocol):
    """A bind under way in the background."""

    @property
    def fraction(self) -> float: ...
    def step(self, time_limit_s: float) -> bool:
        """Goes on, but no longer than that; True while there is more to do."""

    def drop(self) -> None: ...
    def adopt(self) -> None:
        """Makes the result the live session. Raises what the bind raised. Only if it is done."""


class EngineScene(Protocol):
    """What following needs of Blender, for one object."""

    def look(self) -> str:
        """Takes a snapshot of the scene; every step begins with it.

        Returns:
            Why the mesh cannot follow now, '' if it can. Only then may the others be called.
        """

    def has_to_wait(self) -> bool:
        """True while weights are painted: they are known when the stroke has ended."""

    def is_bound(self) -> bool:
        """Whether the live session fits the snapshot: mesh, groups and settings."""

    def begin_bind(self) -> Bind:
        """Reads the scene and begins to bind. Raises ValueError if the scene cannot be posed."""

    def go_on_from_shown(self) -> bool:
        """Starts the live session from the pose that the key shows now. False if it is there already."""

    def is_rebound(self) -> bool:
        """Whether something has bound the mesh, or set its handles, since the last update."""

    def matrices(self) -> NDArray[np.float64]:
        """(h, 4, 4) float64 object-space motions of the handles in the snapshot."""

    def update(self, matrices: NDArray[np.float64], iterations: int | None, time_limit_s: float | None) -> SolveStats:
        """Solves for these motions of the handles and writes the key. Only if is_bound().

        ``iterations`` is a limit; None: that of the settings.
        """

    def update_from_rest(self, matrices: NDArray[np.float64], time_limit_s: float | None) -> SolveStats:
        """As update(), but from rest and to convergence. No time limit: for as long as the scene finds bearable."""

    @property
    def iteration_limit(self) -> int:
        """The most iterations for one place of the handles."""

    def settled(self) -> None:
        """The mesh has settled: nothing is written until something changes."""


class HandleTracker:
    """Follows the handles of one object. Every method may raise what the scene raises."""

    def __init__(self, scene: EngineScene, clock: Callable[[], float] = time.perf_counter) -> None:
        self._scene = scene
        self._clock = clock
        self._besides_s = 0.0  # of the last update, all but the solve
        self._bind: Bind | None = None
        self._bind_began = 0.0
        self._matrices: NDArray[np.float64] | None = None
        self._iterations_here = 0
        self.has_followed = False
        self.stats: SolveStats | None = None
        self.is_settled = False

    @property
    def is_binding(self) -> bool:
        return self._bind is not None

    @property
    def bind_fraction(self) -> float:
        return self._bind.fraction if self._bind is not None else 1.0

    @property
    def bind_s(self) -> float:
        """Seconds that the bind under way has lasted."""
        return self._clock() - self._bind_began if self._bind is not None else 0.0

    def begin(self) -> None:
        """Binds if the session does not fit, else goes on from the pose shown."""
        self._scene.look()
        if self._scene.is_bound():
            self._scene.go_on_from_shown()
        else:
            self._begin_bind()

    def prepare(self, time_limit_s: float = BIND_STEP_S) -> bool:
        """A step of binding, which waits no longer than that for a bind. True if there is nothing to bind."""
        if self._bind is None and self._scene.has_to_wait():
            return False
        if self._bind is None and self._scene.is_bound():
            return True
        if self._bind is None:
            self._begin_bind()
        elif not self._bind.step(time_limit_s):
            bind, self._bind = self._bind, None
            bind.adopt()
        return False

    def is_ready(self) -> bool:
        """Whether it can follow now."""
        return self._bind is None and not self._scene.has_to_wait() and self._scene.is_bound()

    def follow(self, time_limit_s: float | None, *, is_from_rest: bool = False) -> bool:
        """Follows the handles if they have moved. False if they have not; then nothing is done.

        ``time_limit_s`` is for the whole update. The last update tells how much of it is not the solve.
        """
        matrices = self._scene.matrices()
        self.has_followed = True
        is_here = self._matrices is not None and np.array_equal(matrices, self._matrices)
        if is_here and not self._scene.is_rebound():
            return False
        self._matrices = matrices
        self._iterations_here = 0
        limit_s = None if time_limit_s is None else max(time_limit_s - self._besides_s, LEAST_TIME_LIMIT_S)
        start = self._clock()
        if is_from_rest:
            stats = self._scene.update_from_rest(matrices, limit_s)
        else:
            stats = self._scene.update(matrices, None, limit_s)
        self._besides_s = max(self._clock() - start - 1e-3 * stats.last_ms, 0.0)
        self._take(stats)
        return True

    def refine(self, time_limit_s: float) -> None:
        """Goes on iterating at the place that was followed last, unless the mesh has settled there."""
        if not self.is_settled and self._matrices is not None:
            left = self._scene.iteration_limit - self._iterations_here
            self._take(self._scene.update(self._matrices, max(1, left), time_limit_s))

    def forget_place(self) -> None:
        """The next step follows the handles even if they have not moved."""
        self._matrices = None

    def go_on_from_shown(self) -> None:
        """Goes on from the pose that the key shows now. If that is another one, the next step follows the handles."""
        if self._bind is not None or self._scene.go_on_from_shown():
            self.forget_place()

    def drop(self) -> None:
        """Ends a bind that is under way."""
        if self._bind is not None:
            bind, self._bind = self._bind, None
            bind.drop()

    def _begin_bind(self) -> None:
        self._bind_began = self._clock()  # the scene is read first, which takes its time too
        self._bind = self._scene.begin_bind()

    def _take(self, stats: SolveStats) -> None:
        self.stats = stats
        self._iterations_here += stats.iterations
        self.is_settled = stats.stop_reason == "converged" or self._iterations_here >= self._scene.iteration_limit
        if self.is_settled:
            self._scene.settled()


class BindProgress:
    """What panels show of a tracker, for what owns one."""

    _tracker: HandleTracker

    @property
    def is_binding(self) -> bool:
        return self._tracker.is_binding

    @property
    def bind_fraction(self) -> float:
        return self._tracker.bind_fraction

    @property
    def bind_s(self) -> float:
        return self._tracker.bind_s

    @property
    def stats(self) -> SolveStats | None:
        return self._tracker.stats
