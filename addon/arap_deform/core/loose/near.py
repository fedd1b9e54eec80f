# SPDX-License-Identifier: GPL-3.0-or-later
"""Which points are near which places."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats

MOST_IN_CELL = 64  # points to look at if there are more than that near a place: it bounds time and memory


class Cells:
    """Points in cubes of twice the distance that is looked at."""

    def __init__(self, points: Floats, reach: float, most_in_cell: int = MOST_IN_CELL) -> None:
        """Sorts them.

        Args:
            points: (n, 3), at least one.
            reach: more than 0.
            most_in_cell: of the points in a cube, the others are not looked at.
        """
        self._points = points
        self._reach = reach
        self._most = most_in_cell
        self._lowest = points.min(axis=0) - 2.0 * reach
        keys = self._keys(points)
        self._order = np.argsort(keys, kind="stable")
        self._sorted = keys[self._order]

    def pairs(self, places: Floats) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
        """All pairs of a place and a point within reach: rows of (k, 3) ``places``, of the points, distances."""
        rows: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
        candidates = rows.copy()
        # A point within reach lies in one of the cubes that a box of that size touches.
        for corner in itertools.product((-1.0, 1.0), repeat=3):
            wanted = self._keys(places + self._reach * np.array(corner))
            starts, ends = np.searchsorted(self._sorted, wanted), np.searchsorted(self._sorted, wanted, side="right")
            for step in range(min(self._most, int((ends - starts).max(initial=0)))):
                row = np.flatnonzero(starts + step < ends).astype(np.int64)
                rows.append(row)
                candidates.append(self._order[starts[row] + step].astype(np.int64))
        all_rows, found = np.concatenate(rows), np.concatenate(candidates)
        offset = self._points[found] - places[all_rows]
        squares = np.einsum("ij,ij->i", offset, offset)
        is_near = squares <= self._reach * self._reach
        return all_rows[is_near], found[is_near], np.sqrt(squares[is_near])

    def _keys(self, points: Floats) -> NDArray[np.int64]:
        cells = np.floor((points - self._lowest) / (2.0 * self._reach))
        cells = np.clip(cells, -1, 2**20 - 2).astype(np.int64) + 1
        return np.asarray((cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2])
