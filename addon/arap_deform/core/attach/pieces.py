# SPDX-License-Identifier: GPL-3.0-or-later
"""The loose pieces of an attached object, and whether they look as if they were rigid. No bpy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats, Ints
from ..graph import connected_labels, face_edges, fans
from ..loose.pieces import Pieces, numbered

SMALL = 0.25  # of a rigid piece, as a fraction of the size of its host: the diagonals of their boxes
ROUND = 0.4  # of one with an opening, closed: 36 pi volume^2 / area^3, 1 for a ball, 0.6 for half of one
LONG = 2.5  # and its box is at most so many times as long as wide: a sock or a mitten is longer
COMPACT = 0.1  # a rigid piece fills so much of its box: an eye or a tooth does, a glove with two walls does not
COMPACT_RING = 0.25  # and so much if something may go through it: a button or a finger ring does, a belt does not


def loose_pieces(n: int, edges: Ints) -> Ints:
    """(n,) the piece of each vertex, a number from 0 that may leave gaps. ``edges``: (e, 2)."""
    return connected_labels(n, edges[:, 0], edges[:, 1]).astype(np.int32)


def looks_rigid(points: Floats, corner_vertices: Ints, face_sizes: Ints, size: float) -> bool:
    """Whether all pieces are small and compact, as eyes, teeth and buttons are: closed, or round with one opening.

    Args:
        points: (n, 3) as seen.
        corner_vertices, face_sizes: see SessionMesh.
        size: of their host.
    """
    if not len(face_sizes):
        return False
    first, second = face_edges(corner_vertices, face_sizes)
    n_sides = _faces_at(first, second)
    if n_sides.max() > 2:
        return False
    is_in_face = np.zeros(len(points), dtype=bool)
    is_in_face[corner_vertices] = True
    of_vertex = numbered(connected_labels(len(points), first, second), is_in_face)
    pieces = Pieces.of(points, of_vertex)
    if pieces.size.max() > SMALL * size:
        return False
    starts = np.cumsum(face_sizes, dtype=np.int64) - face_sizes
    triangles = fans(corner_vertices, starts, face_sizes)
    of_triangle = of_vertex[triangles[:, 0]]
    lids, of_lid, n_openings = _lids(points, first[n_sides == 1], second[n_sides == 1], of_vertex)
    corners = np.concatenate([points[triangles], lids])
    volumes, areas = _measures(corners - points.mean(axis=0), np.concatenate([of_triangle, of_lid]))
    boxes = pieces.high - pieces.low
    # Euler's formula, openings closed: below 2 there is a hole through it.
    n_edges = _sums(1.0 / n_sides, of_vertex[first])
    n_faces = np.bincount(of_vertex[corner_vertices[starts]])
    is_ring = np.bincount(of_vertex[is_in_face]) - n_edges + n_faces + n_openings < 1.5
    filled = np.where(is_ring, COMPACT_RING, COMPACT) * boxes.prod(axis=1)
    is_compact = (volumes > 0.0) & (volumes >= filled)
    is_round = (36.0 * np.pi * volumes**2 >= ROUND * areas**3) & (boxes.max(axis=1) <= LONG * boxes.min(axis=1))
    return bool((is_compact & ((n_openings == 0) | ((n_openings == 1) & is_round))).all())


def _faces_at(first: Ints, second: Ints) -> NDArray[np.int64]:
    """(c,) how many sides of faces have the edge of each side."""
    sides = np.sort(np.stack([first, second], axis=1).astype(np.int64), axis=1)
    _, edge, counts = np.unique(sides[:, 0] << 32 | sides[:, 1], return_inverse=True, return_counts=True)
    return np.asarray(counts[edge.reshape(-1)])


def _lids(
    points: Floats, first: Ints, second: Ints, of_vertex: NDArray[np.int64]
) -> tuple[Floats, NDArray[np.int64], NDArray[np.int64]]:
    """Closes openings by triangles to their middles.

    Args:
        points: (n, 3).
        first, second: (b,) vertices of the sides that have one face.
        of_vertex: (n,) pieces.

    Returns:
        (b, 3, 3) the corners; (b,) the pieces; (p,) how many openings each piece has.
    """
    opening = numbered(connected_labels(len(points), first, second), np.isin(np.arange(len(points)), first))
    of_side = opening[first]
    sums = np.stack([_sums(points[first, axis], of_side) for axis in range(3)], axis=1)
    middles = sums / _sums(np.ones(len(first)), of_side)[:, None]
    corners = np.stack([points[second], points[first], middles[of_side]], axis=1)
    first_side = np.unique(of_side, return_index=True)[1]
    n_openings = np.bincount(of_vertex[first[first_side]], minlength=int(of_vertex.max()) + 1)
    return corners, of_vertex[first], n_openings.astype(np.int64)


def _sums(values: Floats, group: NDArray[np.int64]) -> Floats:
    """Of the values of each group, by number."""
    return np.asarray(np.bincount(group, weights=values), dtype=np.float64)


def _measures(corners: Floats, of_triangle: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """(p,) volumes and (p,) areas of closed pieces. ``corners``: (t, 3, 3) of their triangles."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    volumes = _sums(np.einsum("ij,ij->i", corners[:, 0], normals) / 6.0, of_triangle)
    return np.abs(volumes), _sums(np.linalg.norm(normals, axis=1) / 2.0, of_triangle)
