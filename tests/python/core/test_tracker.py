# SPDX-License-Identifier: GPL-3.0-or-later
"""Following without Blender: the time that is left for the solve."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from arap_deform.core.session_data import SolveStats
from arap_deform.core.tracker import LEAST_TIME_LIMIT_S, HandleTracker
from fake_engine import FakeEngineScene


@dataclass
class SlowScene(FakeEngineScene):
    """Each update solves for 3 ms and takes ``besides_s`` for the rest."""

    besides_s: float = 0.0
    now: float = 100.0

    def clock(self) -> float:
        return self.now

    def matrices(self) -> np.ndarray:
        self.place += 1.0
        self.now += 5.0  # Blender evaluates the scene
        return super().matrices()

    def solved(self, call: str) -> SolveStats:
        self.now += 0.003 + self.besides_s
        return replace(super().solved(call), last_ms=3.0)


def test_the_solve_gets_what_the_rest_of_the_last_update_leaves() -> None:
    scene = SlowScene(besides_s=0.008)
    tracker = HandleTracker(scene, scene.clock)
    for is_from_rest in (False, False, True):
        tracker.follow(0.014, is_from_rest=is_from_rest)
    scene.besides_s = 0.002
    for _ in range(2):
        tracker.follow(0.014)
    assert [limit_s for _, limit_s in scene.limits] == pytest.approx([0.014, 0.006, 0.006, 0.006, 0.012])


def test_it_asks_for_an_iteration_even_if_no_time_is_left() -> None:
    scene = SlowScene(besides_s=0.05)
    tracker = HandleTracker(scene, scene.clock)
    for limit_s in (0.014, 0.014, None):
        tracker.follow(limit_s)
    assert [limit_s for _, limit_s in scene.limits] == [0.014, LEAST_TIME_LIMIT_S, None]
