# SPDX-License-Identifier: GPL-3.0-or-later
"""The loose pieces of a follower, and whether they look as if they were rigid. No bpy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats, Ints
from ..graph import connected_labels, face_edges, fans
from ..loose.pieces import Pieces, numbered

SMALL = 0.25  # of a rigid piece, as a fraction of the size of what carries it: the diagonals of their boxes
COMPACT = 0.1  # a rigid piece fills so much of its box: an eye or a tooth does, a glove with two walls does not


def loose_pieces(n: int, edges: Ints) -> Ints:
    """(n,) the piece of each vertex, a number from 0 that may leave gaps. ``edges``: (e, 2)."""
    return connected_labels(n, edges[:, 0], edges[:, 1]).astype(np.int32)


def looks_rigid(points: Floats, corner_vertices: Ints, face_sizes: Ints, size: float) -> bool:
    """Whether all pieces are small, closed and compact, as eyes, teeth and buttons are.

    Args:
        points: (n, 3) as seen.
        corner_vertices, face_sizes: see SessionMesh.
        size: of what carries them.
    """
    if not len(face_sizes):
        return False
    first, second = face_edges(corner_vertices, face_sizes)
    if not _is_closed(first, second):
        return False
    is_in_face = np.zeros(len(points), dtype=bool)
    is_in_face[corner_vertices] = True
    of_vertex = numbered(connected_labels(len(points), first, second), is_in_face)
    pieces = Pieces.of(points, of_vertex)
    if pieces.size.max() > SMALL * size:
        return False
    filled = _volumes(points, corner_vertices, face_sizes, of_vertex)
    return bool((filled >= COMPACT * (pieces.high - pieces.low).prod(axis=1)).all() and (filled > 0.0).all())


def _is_closed(first: Ints, second: Ints) -> bool:
    """Whether each side of a face is that of one other face."""
    sides = np.sort(np.stack([first, second], axis=1).astype(np.int64), axis=1)
    counts = np.unique(sides[:, 0] << 32 | sides[:, 1], return_counts=True)[1]
    return bool((counts == 2).all())


def _volumes(points: Floats, corner_vertices: Ints, face_sizes: Ints, of_vertex: NDArray[np.int64]) -> Floats:
    """(p,) volumes of closed pieces."""
    starts = np.cumsum(face_sizes, dtype=np.int64) - face_sizes
    triangles = fans(corner_vertices, starts, face_sizes)
    corners = points[triangles] - points.mean(axis=0)
    of_triangle = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    return np.asarray(np.abs(np.bincount(of_vertex[triangles[:, 0]], weights=of_triangle)))
