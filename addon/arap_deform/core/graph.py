# SPDX-License-Identifier: GPL-3.0-or-later
"""Sides and triangles of faces, and connected pieces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .arrays import Ints


def face_edges(corner_vertices: Ints, face_sizes: Ints) -> tuple[Ints, Ints]:
    """The two vertices of every side of every face, (c,) each."""
    following = np.roll(corner_vertices, -1)
    ends = np.cumsum(face_sizes, dtype=np.int64)
    following[ends - 1] = corner_vertices[ends - face_sizes]
    return corner_vertices, following


def fans(corner_vertices: Ints, starts: NDArray[np.integer], sizes: NDArray[np.integer], corner: int = 0) -> Ints:
    """(t, 3) faces as fans of triangles about their corner of that number; triangles for corner 0 alone.

    Args:
        corner_vertices: (c,) the faces' vertices.
        starts, sizes: (f,) of the faces, their first corner and number of corners.
    """
    is_cut = (sizes > 3) | (corner == 0)
    starts, sizes = starts[is_cut], sizes[is_cut]
    n_triangles = sizes - 2
    face = np.repeat(np.arange(len(starts)), n_triangles)
    place = np.arange(n_triangles.sum()) - np.repeat(np.cumsum(n_triangles) - n_triangles, n_triangles)
    ends = [corner_vertices[starts[face] + (corner + place + i) % sizes[face]] for i in (1, 2)]
    return np.stack([corner_vertices[starts[face] + corner], *ends], axis=1)


def connected_labels(n: int, first: Ints, second: Ints) -> NDArray[np.int64]:
    """(n,) lowest vertex of each vertex's connected piece, for edges first[i] - second[i]."""
    labels: NDArray[np.int64] = np.arange(n)
    while True:
        one, other = labels[first], labels[second]
        differ = one != other
        if not differ.any():
            return labels
        first, second = first[differ], second[differ]
        # Each root is hung on a lower one, whichever is written last. Then every vertex looks up its root.
        labels[np.maximum(one, other)[differ]] = np.minimum(one, other)[differ]
        above = labels[labels]
        while not np.array_equal(above, labels):
            labels, above = above, above[above]
