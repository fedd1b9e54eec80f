# SPDX-License-Identifier: GPL-3.0-or-later
"""What is joined to what: the sides of faces, connected pieces. No bpy."""

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


def connected_labels(n: int, first: Ints, second: Ints) -> NDArray[np.int64]:
    """(n,) lowest vertex of each vertex's connected piece, for edges first[i] - second[i]."""
    labels: NDArray[np.int64] = np.arange(n)
    while True:
        one, other = labels[first], labels[second]
        differ = one != other
        if not differ.any():
            return labels
        first, second = first[differ], second[differ]
        # Roots hang themselves on a lower one, whichever is written last; then everybody looks up his root.
        labels[np.maximum(one, other)[differ]] = np.minimum(one, other)[differ]
        above = labels[labels]
        while not np.array_equal(above, labels):
            labels, above = above, above[above]
