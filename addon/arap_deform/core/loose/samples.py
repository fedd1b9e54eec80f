# SPDX-License-Identifier: GPL-3.0-or-later
"""Points all over a surface: as many on large faces as on small ones, so that its density does not matter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats

MOST_SAMPLES = 200_000  # about as many, before thinning, on the large triangles of a surface
MOST_HALVINGS = 12  # of the sides of a triangle


@dataclass(frozen=True)
class Samples:
    """Points on triangles.

    Attributes:
        places: (m, 3).
        corners: (m, 3) vertices of the triangle that each is on.
        shares: (m, 3) of these vertices in the place; each more than 0.
        pieces: (m,) the piece of the mesh that each is on.
    """

    places: Floats
    corners: NDArray[np.integer]
    shares: Floats
    pieces: NDArray[np.int64]

    def chosen(self, which: NDArray[np.generic]) -> Samples:
        """``which``: rows, or a mask of them."""
        return Samples(self.places[which], self.corners[which], self.shares[which], self.pieces[which])

    def thinned(self, cell: float) -> Samples:
        """One in each cube of that size, for each piece."""
        return self.chosen(self.thinned_rows(cell))

    def thinned_rows(self, cell: float) -> NDArray[np.int64]:
        """Ascending, the rows of thinned()."""
        cells = np.floor((self.places - self.places.min(axis=0)) / cell).astype(np.int64)
        key = self.pieces
        for axis in cells.T:
            key = key * (axis.max() + 1) + axis
        return np.sort(np.unique(key, return_index=True)[1])


def sample(points: Floats, triangles: NDArray[np.integer], pieces: NDArray[np.int64], spacing: float) -> Samples:
    """Samples of (t, 3) triangles, no farther apart than about ``spacing``: one at least on each triangle.

    Args:
        points: (n, 3).
        pieces: (t,) of the triangles.
    """
    first = _longest_first(points, triangles)
    side = points[first[:, 1]] - points[first[:, 0]]
    length = np.linalg.norm(side, axis=1)
    doubled_area = np.linalg.norm(np.cross(side, points[first[:, 2]] - points[first[:, 0]]), axis=1)
    height = doubled_area / np.where(length > 0.0, length, 1.0)
    spacing = max(spacing, float(np.sqrt(doubled_area.sum() / MOST_SAMPLES)))
    halvings = np.stack([_halvings(length, spacing), _halvings(height, spacing)], axis=1)
    parts = []
    for along, across in np.unique(halvings, axis=0):
        rows = np.flatnonzero((halvings == (along, across)).all(axis=1))
        shares = _grid_shares(2**along, 2**across)
        corners = np.repeat(first[rows], len(shares), axis=0)
        tiled = np.tile(shares, (len(rows), 1))
        places = np.einsum("mc,mci->mi", tiled, points[corners])
        parts.append(Samples(places, corners, tiled, np.repeat(pieces[rows], len(shares))))
    columns = zip(*((part.places, part.corners, part.shares, part.pieces) for part in parts), strict=True)
    return Samples(*(np.concatenate(column) for column in columns))


def _longest_first(points: Floats, triangles: NDArray[np.integer]) -> NDArray[np.integer]:
    """The triangles, each from one end of its longest side to the other."""
    ends = points[np.roll(triangles, -1, axis=1)] - points[triangles]
    longest = np.einsum("tci,tci->tc", ends, ends).argmax(axis=1)
    order = (longest[:, None] + np.arange(3)) % 3
    return np.take_along_axis(triangles, order, axis=1)


def _halvings(lengths: Floats, spacing: float) -> NDArray[np.int64]:
    times = np.ceil(np.log2(np.maximum(lengths / spacing, 1.0)))
    return np.asarray(np.minimum(times, MOST_HALVINGS).astype(np.int64))


def _grid_shares(along: int, across: int) -> Floats:
    """Shares of the corners: for a single sample a third each, else in rows from the first side to the last corner."""
    if along == across == 1:
        return np.full((1, 3), 1.0 / 3.0)
    u, v = np.meshgrid((np.arange(along) + 0.5) / along, (np.arange(across) + 0.5) / across)
    u, v = u.ravel(), v.ravel()
    return np.column_stack([(1.0 - v) * (1.0 - u), (1.0 - v) * u, v])
