# SPDX-License-Identifier: GPL-3.0-or-later
"""What contenders of several libraries do in each step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from measure.base.contender import ACCURACY, STEP_ITERATIONS, Floats, PosedTask

CALL_ITERATIONS = 10


def diagonal(task: PosedTask) -> float:
    """Of the bounding box at rest: 1, but for dirty meshes."""
    return float(np.linalg.norm(np.ptp(task.positions, axis=0)))


def settled(iterate: Callable[[Floats], Floats], start: Floats) -> Floats:
    """For libraries that do not say when they are at the end: calls until one moves no vertex more than ACCURACY.

    ``iterate`` goes on by CALL_ITERATIONS from positions (n, 3); STEP_ITERATIONS are the most.
    """
    now = start
    for _ in range(STEP_ITERATIONS // CALL_ITERATIONS):
        before, now = now, iterate(now)
        if np.linalg.norm(now - before, axis=1).max() <= ACCURACY:
            break
    return now


def motion_of_moved(task: PosedTask, step: int) -> tuple[Floats, Floats]:
    """The rotation (3, 3) and the shift (3,) that take what is moved to its targets, p to rotation p + shift."""
    turn = task.rotations[step]
    targets = task.targets[step, len(task.held) :]
    return turn, targets.mean(axis=0) - turn @ task.positions[task.moved].mean(axis=0)
