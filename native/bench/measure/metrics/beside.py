# SPDX-License-Identifier: GPL-3.0-or-later
"""How far points are from a closed surface, and on which side: MeshLab measures."""

from __future__ import annotations

import numpy as np
import pymeshlab

from ..inputs.mesh import Floats, Ints


def signed_distances(points: Floats, positions: Floats, triangles: Ints) -> Floats:
    """(k,) of points (k, 3); < 0: inside."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(positions, triangles))
    meshes.add_mesh(pymeshlab.Mesh(points))
    meshes.compute_scalar_by_distance_from_another_mesh_per_vertex(measuremesh=1, refmesh=0, signeddist=True)
    return np.asarray(meshes.current_mesh().vertex_scalar_array(), dtype=np.float64)
