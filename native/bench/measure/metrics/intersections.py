# SPDX-License-Identifier: GPL-3.0-or-later
"""Faces that pass through other faces: MeshLab finds them."""

from __future__ import annotations

import numpy as np
import pymeshlab

from ..inputs.mesh import Floats, Ints, Mask


def new_intersections(triangles: Ints, rest: Floats, now: Floats, free: Mask) -> int:
    """Faces with a free corner that intersect others, beyond those at rest; less than 0 where some came apart."""
    is_free = free[triangles].any(axis=1)
    before, after = (int(np.count_nonzero(is_free & intersecting(p, triangles))) for p in (rest, now))
    return after - before


def intersecting(positions: Floats, triangles: Ints) -> Mask:
    """(f,) which faces intersect others; those that share a vertex may touch there."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(positions, triangles))
    meshes.compute_selection_by_self_intersections_per_face()
    return np.asarray(meshes.current_mesh().face_selection_array(), dtype=bool)
