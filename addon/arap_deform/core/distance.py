# SPDX-License-Identifier: GPL-3.0-or-later
"""Distances along a surface, and weights that fade with them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats, Ints
from .graph import fans

SETTLED = 1e-5  # a change of distance below this fraction of the radius is not passed on


def distances_within(
    points: Floats, corner_vertices: Ints, face_sizes: Ints, sources: Ints, radius: float
) -> NDArray[np.float64]:
    """(n,) distance of each vertex from the nearest of ``sources``, along the faces; infinite beyond ``radius``.

    The distance at a corner of a triangle is the least over the points of the opposite side: the distance there,
    linear between its ends, plus the straight way to the corner (Hopf-Lax). So a way is not bound to the edges. On a
    plane it is straight, but for how the faces are cut.

    Args:
        points: (n, 3).
        corner_vertices: (c,) the faces' vertices, one face after the other.
        face_sizes: (f,).
        sources: (k,), at least one.
        radius: 0 or more.
    """
    distances = np.full(len(points), np.inf)
    distances[sources] = 0.0
    if radius == 0.0:
        return distances
    steps = _Steps.over(_triangles_near(points, corner_vertices, face_sizes, sources, radius), points)
    band = float(steps.side.mean()) if len(steps.side) else 0.0
    has_changed = np.isfinite(distances)
    while has_changed.any():
        # The nearest first, so that few vertices are passed on more than once.
        changed = np.flatnonzero(has_changed)
        changed = changed[distances[changed] <= distances[changed].min() + band]
        has_changed[changed] = False
        rows = steps.rows_from(changed)
        if len(rows):
            targets = steps.target[rows]
            starts = np.flatnonzero(np.diff(targets, prepend=-1))  # rows are in the order of their targets
            nearest = np.minimum.reduceat(steps.distances(rows, distances), starts)
            reached = targets[starts]
            is_nearer = (nearest < distances[reached] - SETTLED * radius) & (nearest <= radius)
            distances[reached[is_nearer]] = nearest[is_nearer]
            has_changed[reached[is_nearer]] = True
    return distances


def faded(distances: Floats, radius: float) -> NDArray[np.float64]:
    """(n,) weights: 1 at distance 0, 0 from ``radius`` on, smooth at both ends."""
    share = np.clip(1.0 - distances / radius, 0.0, 1.0) if radius > 0.0 else (distances == 0.0).astype(float)
    return np.asarray(share * share * (3.0 - 2.0 * share))


@dataclass(frozen=True)
class _Steps:
    """Ways over a triangle, from a side to the opposite corner, in the order of their targets.

    Attributes:
        first, second, target: (m,) vertices: the ends of the side, and the corner.
        side: (m,) length of the side.
        along, across: (m,) place of the corner: along the side from its first end, and off it.
        rows, offsets: (2 m,) the ways from each vertex, and (n + 1,) the first of each vertex.
    """

    first: Ints
    second: Ints
    target: Ints
    side: Floats
    along: Floats
    across: Floats
    rows: NDArray[np.int64]
    offsets: NDArray[np.int64]

    @classmethod
    def over(cls, triangles: Ints, points: Floats) -> _Steps:
        """Args: (t, 3) triangles; a triangle with a side of no length is left out."""
        ways = np.concatenate([triangles, triangles[:, [1, 2, 0]], triangles[:, [2, 0, 1]]])
        ways = ways[np.argsort(ways[:, 2], kind="stable")]
        start, to_end = points[ways[:, 0]], points[ways[:, 1]] - points[ways[:, 0]]
        side = np.linalg.norm(to_end, axis=1)
        ways, start, to_end, side = (array[side > 0.0] for array in (ways, start, to_end, side))
        to_corner = points[ways[:, 2]] - start
        along = np.einsum("ij,ij->i", to_corner, to_end) / side
        across = np.linalg.norm(to_corner - (along / side)[:, None] * to_end, axis=1)
        ends = np.concatenate([ways[:, 0], ways[:, 1]])
        rows = np.argsort(ends, kind="stable")
        offsets = np.concatenate([[0], np.cumsum(np.bincount(ends, minlength=len(points)))])
        return cls(ways[:, 0], ways[:, 1], ways[:, 2], side, along, across, rows % max(1, len(ways)), offsets)

    def rows_from(self, vertices: NDArray[np.int64]) -> NDArray[np.int64]:
        """Ascending, the ways from these vertices."""
        begins, counts = self.offsets[vertices], self.offsets[vertices + 1] - self.offsets[vertices]
        place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        return np.asarray(np.unique(self.rows[np.repeat(begins, counts) + place]))

    def distances(self, rows: NDArray[np.int64], distances: Floats) -> NDArray[np.float64]:
        """What these ways give their targets, for (n,) ``distances`` of all vertices."""
        at_first, at_second = distances[self.first[rows]], distances[self.second[rows]]
        side, along, across = self.side[rows], self.along[rows], self.across[rows]
        is_known = np.isfinite(at_first) & np.isfinite(at_second)
        slope = np.zeros(len(rows))
        slope[is_known] = (at_second[is_known] - at_first[is_known]) / side[is_known]
        # The place at which the way to the corner leaves the side: its angle with the side has the cosine slope.
        is_inside = is_known & (np.abs(slope) < 1.0)
        crossing = np.where(is_inside, along - across * slope / np.sqrt(np.where(is_inside, 1.0 - slope**2, 1.0)), -1.0)
        is_inside &= (crossing > 0.0) & (crossing < side)
        result: NDArray[np.float64] = np.minimum(
            at_first + np.hypot(along, across), at_second + np.hypot(side - along, across)
        )
        straight = at_first[is_inside] + slope[is_inside] * crossing[is_inside]
        straight += np.hypot(along[is_inside] - crossing[is_inside], across[is_inside])
        result[is_inside] = np.minimum(result[is_inside], straight)
        return result


def _triangles_near(points: Floats, corner_vertices: Ints, face_sizes: Ints, sources: Ints, radius: float) -> Ints:
    """(t, 3) triangles of the faces that have all corners within ``radius`` of the box of ``sources``."""
    lowest, highest = points[sources].min(axis=0) - radius, points[sources].max(axis=0) + radius
    is_near = ((points >= lowest) & (points <= highest)).all(axis=1)
    starts = np.cumsum(face_sizes, dtype=np.int64) - face_sizes
    is_face_near = np.logical_and.reduceat(is_near[corner_vertices], starts)
    starts, sizes = starts[is_face_near], face_sizes[is_face_near].astype(np.int64)
    # Fans from two corners: a quad is cut both ways, so that no diagonal is preferred.
    return np.concatenate([fans(corner_vertices, starts, sizes, corner) for corner in (0, 1)]).astype(np.int32)
