# SPDX-License-Identifier: GPL-3.0-or-later
"""A shape whose long edges are split, so that it can bend there. No bpy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .shape import Longs, Shape

Chooser = Callable[[Shape], NDArray[np.bool_]]
"""Which vertices of a shape are meant, (n,)."""


def split_edges(shape: Shape, length: float, chosen: Chooser | None = None) -> Shape:
    """Halves edges until none is longer. ``chosen``: only those of triangles with such a vertex, as it is at each time.

    The vertices stay, and new ones come after them. These are in a group as much as both ends of their edge.
    """
    while True:
        middles, ends = _long_edges(shape, length, chosen)
        if not len(ends):
            return shape
        points = np.concatenate([shape.points, shape.points[ends].mean(axis=1)])
        weights = np.concatenate([shape.weights, shape.weights[:, ends].min(axis=2)], axis=1)
        shape = Shape(points, _split(shape.triangles, middles), weights)


def _long_edges(shape: Shape, length: float, chosen: Chooser | None) -> tuple[Longs, Longs]:
    """(t, 3) number of the new vertex on the side after each corner, -1: it is not split. And (k, 2) their edges."""
    first, second = shape.triangles, np.roll(shape.triangles, -1, axis=1)
    offset = shape.points[second] - shape.points[first]
    is_long = np.asarray(np.einsum("tki,tki->tk", offset, offset) > length * length)
    keys = (np.minimum(first, second)[is_long] << 32) | np.maximum(first, second)[is_long]
    is_meant: NDArray[np.bool_] = np.ones(len(keys), dtype=bool)
    if chosen is not None and len(keys):
        # All long sides of a triangle, or its longest one could stay, and others would be split for ever.
        is_near = np.asarray(chosen(shape)[first]).any(axis=1)
        is_meant = np.repeat(is_near, 3).reshape(first.shape)[is_long]
    edges = np.unique(keys[is_meant])
    numbers = np.searchsorted(edges, keys)
    # An edge is split for all its triangles.
    is_split = edges[np.minimum(numbers, len(edges) - 1)] == keys if len(edges) else is_meant
    middles = np.full(shape.triangles.shape, -1, dtype=np.int64)
    middles[is_long] = np.where(is_split, len(shape.points) + numbers, -1)
    return middles, np.stack([edges >> 32, edges & 0xFFFFFFFF], axis=1)


def _split(triangles: Longs, middles: Longs) -> Longs:
    """(t, 3) the triangles with new vertices on their sides; windings stay."""
    n_split = (middles >= 0).sum(axis=1)
    pieces = [triangles[n_split == 0]]
    # One side: turned so that it is the first one.
    (a, b, c), (ab, _, _) = _turned(triangles, middles, n_split == 1, middles >= 0)
    pieces += [np.stack([a, ab, c], axis=1), np.stack([ab, b, c], axis=1)]
    # Two sides: the last one is whole.
    (a, b, c), (ab, bc, _) = _turned(triangles, middles, n_split == 2, np.roll(middles < 0, 1, axis=1))
    pieces += [np.stack([ab, b, bc], axis=1), np.stack([a, ab, bc], axis=1), np.stack([a, bc, c], axis=1)]
    (a, b, c), (ab, bc, ca) = triangles[n_split == 3].T, middles[n_split == 3].T
    corners = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
    return np.concatenate([*pieces, *(np.stack(corner, axis=1) for corner in corners)])


def _turned(
    triangles: Longs, middles: Longs, rows: NDArray[np.bool_], is_first: NDArray[np.bool_]
) -> tuple[Longs, Longs]:
    """(3, k) corners and new vertices of these rows, turned so that the side with ``is_first`` comes first."""
    turn = (is_first[rows].argmax(axis=1)[:, None] + np.arange(3)) % 3
    return np.take_along_axis(triangles[rows], turn, 1).T, np.take_along_axis(middles[rows], turn, 1).T
