# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights of vertex groups -> stiffness and rigid regions; connected pieces. No bpy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .handle_map import Floats, Ints
from .session_data import SessionMesh

RIGID_WEIGHT = 0.5  # weight in the rigid group from which a vertex belongs to a region
STIFFEST = 100.0  # stiffness at weight 1; in between it grows by the same factor for the same step of weight


def stiffness_of(weights: Floats) -> Floats:
    """(n,) stiffness of each vertex: STIFFEST ** weight."""
    return np.asarray(STIFFEST ** np.clip(weights, 0.0, 1.0))


def regions_of(weights: Floats, mesh: SessionMesh) -> Ints:
    """(n,) int32 rigid region of each vertex, -1 for none: the connected pieces of weights >= RIGID_WEIGHT."""
    is_rigid = weights >= RIGID_WEIGHT
    first, second = face_edges(mesh.corner_vertices, mesh.face_sizes)
    inside = is_rigid[first] & is_rigid[second]
    labels = connected_labels(len(weights), first[inside], second[inside])
    _, regions = np.unique(np.where(is_rigid, labels, -1), return_inverse=True)
    return np.where(is_rigid, regions, -1).astype(np.int32)


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
