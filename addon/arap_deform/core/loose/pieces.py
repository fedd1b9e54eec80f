# SPDX-License-Identifier: GPL-3.0-or-later
"""The pieces of a mesh: how large each is, and which is inside which."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats, Ints
from ..graph import connected_labels

INSIDE_MARGIN = 0.1  # a box reaches so far beyond another that it is inside of, as a fraction of the larger one's size
LARGER = 1.5  # what others go along with is so many times as large


@dataclass(frozen=True)
class Pieces:
    """Connected pieces, by number. A vertex in no face is in none.

    Attributes:
        points: (n, 3) the mesh at rest, as seen.
        of_vertex: (n,) number of its piece, -1 for none.
        first_vertex: (p,) the lowest of each.
        low, high: (p, 3) corners of their boxes.
        size: (p,) diagonals of these.
    """

    points: Floats
    of_vertex: NDArray[np.int64]
    first_vertex: NDArray[np.int64]
    low: Floats
    high: Floats
    size: Floats

    @classmethod
    def of(cls, points: Floats, of_vertex: NDArray[np.integer]) -> Pieces:
        """``of_vertex``: numbers from 0 without a gap, -1 for none."""
        order = np.argsort(of_vertex, kind="stable")
        order = order[of_vertex[order] >= 0]
        starts = np.flatnonzero(np.diff(of_vertex[order], prepend=-1))
        ordered = points[order]
        low = np.minimum.reduceat(ordered, starts, axis=0)
        high = np.maximum.reduceat(ordered, starts, axis=0)
        return cls(points, of_vertex.astype(np.int64), order[starts], low, high, np.linalg.norm(high - low, axis=1))

    def is_near(self, which: NDArray[np.bool_], distance: float) -> NDArray[np.bool_]:
        """(p,) whether the box of each piece comes so near to the box around ``which`` pieces, along each axis."""
        low, high = self.low[which].min(axis=0) - distance, self.high[which].max(axis=0) + distance
        return np.asarray(((self.high >= low) & (self.low <= high)).all(axis=1))

    def reach_near(
        self, triangles: NDArray[np.integer], which: NDArray[np.bool_], distance: float
    ) -> NDArray[np.bool_]:
        """(t,) whether each of (t, 3) ``triangles`` comes so near to the box around these pieces, along each axis."""
        low, high = self.low[which].min(axis=0) - distance, self.high[which].max(axis=0) + distance
        is_beyond = np.zeros(len(triangles), dtype=bool)
        for axis in range(3):
            along = self.points[:, axis]
            for is_outside in (along < low[axis], along > high[axis]):
                is_beyond |= is_outside[triangles].all(axis=1)
        return ~is_beyond

    def is_middle_inside(self, inner: NDArray[np.int64], outer: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(k,) whether the middle of each ``inner`` piece's box lies in the box of the ``outer`` one."""
        middle = 0.5 * (self.low + self.high)[inner]
        return np.asarray(((middle >= self.low[outer]) & (middle <= self.high[outer])).all(axis=1))

    def is_inside(self, inner: NDArray[np.int64], outer: NDArray[np.int64]) -> NDArray[np.bool_]:
        """(k,) whether the box of each ``inner`` piece lies in that of the ``outer`` one."""
        margin = INSIDE_MARGIN * self.size[outer][:, None]
        is_within = (self.low[inner] >= self.low[outer] - margin) & (self.high[inner] <= self.high[outer] + margin)
        return np.asarray(is_within.all(axis=1) & (self.size[outer] >= LARGER * self.size[inner]))


def numbered(labels: NDArray[np.integer], is_in_face: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(n,) ``labels`` of pieces as numbers from 0 without a gap; -1 for vertices in no face."""
    numbers = np.full(len(labels), -1, dtype=np.int64)
    numbers[is_in_face] = np.unique(labels[is_in_face], return_inverse=True)[1]
    return numbers


def joined_by_regions(of_vertex: NDArray[np.integer], regions: Ints | None) -> NDArray[np.int64]:
    """(n,) numbers of pieces, without a gap; those with vertices in one rigid region are one.

    Args:
        of_vertex: (n,) numbers of connected pieces, -1 for none.
        regions: (n,) region of each vertex, negative for none.
    """
    is_in_face = of_vertex >= 0
    if regions is None or not is_in_face.any():
        return numbered(of_vertex, is_in_face)
    n_pieces = int(of_vertex.max()) + 1
    is_linked = is_in_face & (regions >= 0)
    linked, regions = of_vertex[is_linked].astype(np.int32), regions[is_linked].astype(np.int32)
    labels = connected_labels(n_pieces + int(regions.max(initial=-1)) + 1, linked, n_pieces + regions)
    return numbered(labels[of_vertex], is_in_face)
