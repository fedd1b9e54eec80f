# SPDX-License-Identifier: GPL-3.0-or-later
"""Triangles with weights: several meshes as one, and vertices joined by place. No bpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..arrays import Float32s, Floats, Ints
from ..graph import connected_labels, fans

Longs = NDArray[np.int64]

SAME_IMAGE = 1e-4  # of the size: so near is a vertex to the mirror image of another one


@dataclass(frozen=True)
class Shape:
    """A mesh of triangles.

    Attributes:
        points: (n, 3) float64.
        triangles: (t, 3) int64.
        weights: (g, n) float32, of g vertex groups.
    """

    points: Floats
    triangles: Longs
    weights: Float32s

    @property
    def size(self) -> float:
        """Diagonal of the box."""
        return float(np.linalg.norm(np.ptp(self.points, axis=0))) if len(self.points) else 0.0

    @property
    def area(self) -> float:
        a, b, c = (self.points[corner] for corner in self.triangles.T)
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2.0


def joined(shapes: Sequence[Shape]) -> Shape:
    """All of them as one, in this order. They have the same groups. Vertices in no triangle are left out."""
    starts = np.cumsum([0, *(len(shape.points) for shape in shapes[:-1])])
    triangles = np.concatenate([shape.triangles + start for shape, start in zip(shapes, starts, strict=True)])
    points = np.concatenate([shape.points for shape in shapes])
    return _without_loose(points, triangles, np.concatenate([shape.weights for shape in shapes], axis=1))


def _without_loose(points: Floats, triangles: Longs, weights: Float32s) -> Shape:
    is_used = np.zeros(len(points), dtype=bool)
    is_used[triangles.ravel()] = True
    if is_used.all():
        return Shape(points, triangles, weights)
    numbers = np.cumsum(is_used) - 1
    return Shape(points[is_used], numbers[triangles], weights[:, is_used])


def cells_of(points: Floats, size: float, shift: float = 0.0) -> Longs:
    """(n,) the cube of each point, of this size; ``shift`` of all cubes, as a fraction of it."""
    places = np.floor((points - points.min(axis=0)) / size + shift).astype(np.int64)
    counts = places.max(axis=0) + 1
    return np.asarray((places[:, 0] * counts[1] + places[:, 1]) * counts[2] + places[:, 2])


def centre_of(shape: Shape) -> Floats:
    """(3,) the middle of the box; along an axis 0, if more vertices have mirror images about that.

    A figure that holds something is symmetric about where it was modelled, not about the middle of all.
    """
    low, high = shape.points.min(axis=0), shape.points.max(axis=0)
    centre: Floats = (low + high) / 2.0
    for axis in range(3):
        if low[axis] < 0.0 < high[axis] and _n_images(shape, axis, 0.0) > _n_images(shape, axis, centre[axis]):
            centre[axis] = 0.0
    return centre


def _n_images(shape: Shape, axis: int, place: float) -> int:
    """How many vertices have a mirror image about a plane across the axis."""
    mirrored = shape.points.copy()
    mirrored[:, axis] = 2.0 * place - mirrored[:, axis]
    # Shifted: many coordinates are round numbers, which rounding would bring to either side of a cube.
    cells = cells_of(np.concatenate([shape.points, mirrored]), SAME_IMAGE * shape.size, 0.37)
    n = len(shape.points)
    return int(np.isin(cells[n:], cells[:n]).sum())


def clustered(shape: Shape, size: float) -> Shape:
    """All vertices in a cube of this size as one, at their mean, with their largest weights.

    Triangles without area or on others are left out. Those of opposite windings, as of a thin wall, stay.
    """
    cells, numbers = np.unique(cells_of(shape.points, size), return_inverse=True)
    numbers = numbers.reshape(-1)  # numpy 2.0 gives another shape
    n = len(cells)
    counts = np.bincount(numbers, minlength=n)
    points = np.stack([np.bincount(numbers, column, n) / counts for column in shape.points.T], axis=1)
    return _without_loose(points, _distinct(numbers[shape.triangles], n), _largest(shape.weights, numbers, counts))


def _distinct(triangles: Longs, n: int) -> Longs:
    """Those with three vertices, once each. ``n`` vertices, at most two million."""
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    first = triangles.argmin(axis=1)
    rows = np.arange(len(triangles))
    a, b, c = (triangles[rows, (first + k) % 3] for k in range(3))
    if n > 2**21:  # the key would not fit; these are fine enough to have hardly any on others
        return np.stack([a, b, c], axis=1)
    kept = np.unique((a << 42) | (b << 21) | c)
    return np.stack([kept >> 42, (kept >> 21) & (2**21 - 1), kept & (2**21 - 1)], axis=1)


def _largest(weights: Float32s, numbers: Longs, counts: Longs) -> Float32s:
    """(g, m) largest weight of the vertices with each number."""
    if not len(weights):
        return np.empty((0, len(counts)), dtype=np.float32)
    starts = np.cumsum(counts) - counts
    return np.maximum.reduceat(weights[:, np.argsort(numbers, kind="stable")], starts, axis=1)


def parts_of(shape: Shape) -> Longs:
    """(n,) lowest vertex of the connected part of each vertex."""
    a, b, c = shape.triangles.T
    return connected_labels(len(shape.points), np.concatenate([a, b]), np.concatenate([b, c]))


def triangles_of(corner_vertices: Ints, face_sizes: Ints) -> Longs:
    """(t, 3) faces as fans of triangles about their first corners."""
    starts = np.cumsum(face_sizes, dtype=np.int64) - face_sizes
    return fans(corner_vertices, starts, face_sizes).astype(np.int64)
