# SPDX-License-Identifier: GPL-3.0-or-later
"""Which points are near which places."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats

MOST_IN_CELL = 64  # points to look at if there are more than that near a place: it bounds time and memory


def pairs_within(
    points: Floats, places: Floats, reach: float, most_in_cell: int = MOST_IN_CELL
) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """All pairs of a place and a point within ``reach``: rows of ``places``, of ``points``, distances; (p,) each.

    Args:
        points: (n, 3).
        places: (k, 3).
        reach: more than 0.
        most_in_cell: of the points in a cube of 2 ``reach``, the others are not looked at.
    """
    cell = 2.0 * reach
    lowest = points.min(axis=0) - cell
    keys = _cell_keys(points, lowest, cell)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    rows: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
    candidates = rows.copy()
    # A point within reach lies in one of the cells that a box of that size touches.
    for corner in itertools.product((-0.5, 0.5), repeat=3):
        wanted = _cell_keys(places + cell * np.array(corner), lowest, cell)
        starts, ends = np.searchsorted(keys, wanted), np.searchsorted(keys, wanted, side="right")
        for step in range(min(most_in_cell, int((ends - starts).max(initial=0)))):
            row = np.flatnonzero(starts + step < ends).astype(np.int64)
            rows.append(row)
            candidates.append(order[starts[row] + step].astype(np.int64))
    all_rows, found = np.concatenate(rows), np.concatenate(candidates)
    offset = points[found] - places[all_rows]
    squares = np.einsum("ij,ij->i", offset, offset)
    is_near = squares <= reach * reach
    return all_rows[is_near], found[is_near], np.sqrt(squares[is_near])


def _cell_keys(points: Floats, lowest: Floats, cell: float) -> NDArray[np.int64]:
    cells = np.clip(np.floor((points - lowest) / cell), -1, 2**20 - 2).astype(np.int64) + 1
    return np.asarray((cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2])
