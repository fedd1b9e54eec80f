# SPDX-License-Identifier: GPL-3.0-or-later
"""The cages of arap_native: made by make_cage, and moved by what is held and moved of the mesh.

Each held and each moved vertex has a nearest vertex of the cage. Those make the motion of what they are near, as a
body; the cage's other vertices follow as rigidly as its own surface can.
"""

from __future__ import annotations

from typing import Any

import arap_native
import numpy as np
from measure.base.contender import CAGE, CAGE_GROUP, HANDLE, PIN, Floats, Ints, Make, PosedTask

from .ours import OPTIONS, arrays

CHUNK = 1 << 22  # distances at a time


class CageByHandles:
    """A cage whose coordinates carry the mesh."""

    version = arap_native.__version__
    acts = (PIN, HANDLE, CAGE, CAGE_GROUP, CAGE_GROUP)

    def __init__(self, task: PosedTask, coordinates: Any) -> None:
        self._task, self._positions = task, task.positions
        cage, corners, sizes = arap_native.make_cage(*arrays(task))
        self._held, self._moved = cage_groups(task, cage)
        self._cage = cage
        self._arap = arap_native.SurfaceArap(cage, corners, sizes)
        self._arap.set_constraints(np.concatenate([self._held, self._moved]))
        options = arap_native.CageOptions(coordinates=coordinates)
        self._carried = arap_native.CageDeformation(task.positions, cage, corners, sizes, options)

    def pose(self, step: int) -> None:
        moved = carried_along(self._task, step, self._cage[self._moved])
        targets = np.concatenate([self._cage[self._held], moved])
        self._positions = self._carried.deform(self._arap.solve(targets, OPTIONS).positions)

    def positions(self) -> Floats:
        return np.asarray(self._positions)


def cage_groups(task: PosedTask, cage: Floats) -> tuple[Ints, Ints]:
    """The cage's vertices that are nearest to something held, and to something moved; the nearer one where to both."""
    nearest = [nearest_of(cage, task.positions[part]) for part in (task.held, task.moved)]
    distance = np.full((2, len(cage)), np.inf)
    for row, (vertices, away) in zip(distance, nearest, strict=True):
        np.minimum.at(row, vertices, away)
    is_chosen = np.isfinite(distance)
    held, moved = is_chosen[0] & (distance[0] <= distance[1]), is_chosen[1] & (distance[1] < distance[0])
    return np.flatnonzero(held).astype(np.int32), np.flatnonzero(moved).astype(np.int32)


def nearest_of(places: Floats, points: Floats) -> tuple[Ints, Floats]:
    """For each point (k, 3) the index of the nearest place (c, 3), and its distance."""
    rows = max(1, CHUNK // len(places))
    found: list[Any] = []
    for first in range(0, len(points), rows):
        away = np.linalg.norm(points[first : first + rows, None] - places, axis=2)
        best = away.argmin(axis=1)
        found.append((best, away[np.arange(len(best)), best]))
    indices, distances = (np.concatenate(column) for column in zip(*found, strict=True))
    return indices, distances


def carried_along(task: PosedTask, step: int, points: Floats) -> Floats:
    """(k, 3) points at rest, moved as a body with what is moved."""
    rest, now = task.positions[task.moved], task.targets[step, len(task.held) :]
    return np.asarray((points - rest.mean(axis=0)) @ task.rotations[step].T + now.mean(axis=0))


def cage(coordinates: str) -> Make:
    return lambda task: CageByHandles(task, coordinates)


MODELS: dict[str, Make] = {
    "cage, mean value": cage("mean_value"),
    "cage, harmonic": cage("harmonic"),
    "cage, Green": cage("green"),
}
