# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights of vertex groups -> stiffness and rigid regions. No bpy."""

from __future__ import annotations

import numpy as np

from .handle_map import Floats, Ints
from .mesh_graph import connected_labels, face_edges
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
