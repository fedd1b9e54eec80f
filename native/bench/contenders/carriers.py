# SPDX-License-Identifier: GPL-3.0-or-later
"""Coarse meshes that carry a finer one, moved as its held and moved vertices say. A person would move them by hand."""

from __future__ import annotations

import arap_native
import numpy as np
from measure.base.contender import ACCURACY, STEP_ITERATIONS, Floats, Ints, PosedTask

from .steps import motion_of_moved


class Carrier:
    """Its vertices next to what is held stay, those next to what is moved go along, the rest is posed by ARAP.

    Attributes:
        rest: (c, 3) places of its vertices.
        corner_vertices, face_sizes: its faces.
    """

    def __init__(self, task: PosedTask, rest: Floats, corner_vertices: Ints, face_sizes: Ints) -> None:
        self.rest, self.corner_vertices, self.face_sizes = rest, corner_vertices, face_sizes
        self._task = task
        held, moved = (nearest(task.positions[part], self.rest) for part in (task.held, task.moved))
        self._held, self._moved = np.setdiff1d(held, moved), np.unique(moved)
        self._arap = arap_native.SurfaceArap(self.rest, self.corner_vertices, self.face_sizes)
        self._arap.set_constraints(np.concatenate([self._held, self._moved]))

    def pose(self, step: int) -> Floats:
        """(c, 3) where its vertices are in a step."""
        turn, shift = motion_of_moved(self._task, step)
        targets = np.concatenate([self.rest[self._held], self.rest[self._moved] @ turn.T + shift])
        options = arap_native.SolveOptions(accuracy=ACCURACY, max_iterations=STEP_ITERATIONS)
        return np.asarray(self._arap.solve(targets, options).positions)


def automatic_cage(task: PosedTask) -> Carrier:
    return Carrier(task, *arap_native.make_cage(task.positions, task.corner_vertices, task.face_sizes))


def nearest(points: Floats, places: Floats) -> Ints:
    """(k,) which of the places (c, 3) is nearest to each of the points (k, 3)."""
    half_squares = 0.5 * np.einsum("ij,ij->i", places, places)
    return np.argmin(half_squares - points @ places.T, axis=1).astype(np.int32)
