# SPDX-License-Identifier: GPL-3.0-or-later
"""Coarse meshes that carry a fine one, moved by what is held and moved of it.

Each held and each moved vertex has a nearest vertex of the coarse mesh. Those make the motion of what they are near,
as a body; the other vertices follow as rigidly as the coarse mesh's own surface can.
"""

from __future__ import annotations

from typing import Any

import arap_native
import numpy as np
from measure.base.contender import Floats, Ints, PosedTask

from .ours import OPTIONS, arrays
from .steps import motion_of_moved

AS_NEAR = 1 + 1e-9
CHUNK = 1 << 22  # distances at a time


class Carrier:
    """A coarse mesh.

    Attributes:
        arrays: at rest: positions (c, 3), corner vertices and face sizes.
    """

    def __init__(self, task: PosedTask, positions: Floats, corner_vertices: Ints, face_sizes: Ints) -> None:
        self.arrays = positions, corner_vertices, face_sizes
        self._task = task
        self._held, self._moved = groups(task, positions)
        self._arap = arap_native.SurfaceArap(*self.arrays)
        self._arap.set_constraints(np.concatenate([self._held, self._moved]))

    def pose(self, step: int) -> Floats:
        """(c, 3) positions in a step."""
        rest, (turn, shift) = self.arrays[0], motion_of_moved(self._task, step)
        targets = np.concatenate([rest[self._held], rest[self._moved] @ turn.T + shift])
        return np.asarray(self._arap.solve(targets, OPTIONS).positions)


def automatic_cage(task: PosedTask) -> Carrier:
    positions, quads = arap_native.make_cage(*arrays(task))
    return Carrier(task, positions, quads.ravel(), np.full(len(quads), quads.shape[1], dtype=np.int32))


def groups(task: PosedTask, coarse: Floats) -> tuple[Ints, Ints]:
    """The coarse vertices nearest to something held, and to something moved; the nearer one where to both."""
    nearest = [nearest_of(coarse, task.positions[part]) for part in (task.held, task.moved)]
    distance = np.full((2, len(coarse)), np.inf)
    for row, (vertices, away) in zip(distance, nearest, strict=True):
        np.minimum.at(row, vertices, away)
    is_chosen = np.isfinite(distance)
    held, moved = is_chosen[0] & (distance[0] <= distance[1]), is_chosen[1] & (distance[1] < distance[0])
    return np.flatnonzero(held).astype(np.int32), np.flatnonzero(moved).astype(np.int32)


def nearest_of(places: Floats, points: Floats) -> tuple[Ints, Floats]:
    """For each point (k, 3) the indices of the nearest places (c, 3), one after the other, and their distances.

    Where several are as near but for rounding, all: so what is symmetric stays so.
    """
    rows = max(1, CHUNK // len(places))
    found: list[Any] = []
    for first in range(0, len(points), rows):
        away = np.linalg.norm(points[first : first + rows, None] - places, axis=2)
        point, place = np.nonzero(away <= AS_NEAR * away.min(axis=1, keepdims=True))
        found.append((place, away[point, place]))
    indices, distances = (np.concatenate(column) for column in zip(*found, strict=True))
    return indices, distances
