# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices do not move: parts of the mesh without a pin or handle, and loose vertices."""

from __future__ import annotations

import bpy
import numpy as np

from ..core import native
from ..core.arrays import Ints
from ..core.graph import connected_labels, face_edges
from . import handle_motion, meshes
from .inputs import enabled_holds


def find(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> tuple[Ints, int]:
    """The vertices, (k,) int32 ascending, and how many parts of the mesh they are, loose ones not counted.

    Raises:
        ValueError: as read_input(), if the mesh cannot be used or has no pin and no handle.
        RuntimeError: the native module cannot be used.
    """
    meshes.check_mesh(obj)
    handle_motion.check_handles(obj, depsgraph)
    names = sorted({hold.group for hold in enabled_holds(obj)})
    if not names:
        raise ValueError(f"Nothing holds or moves '{obj.name}': add a pin or a handle")
    is_held = np.any([weights > 0.0 for weights in meshes.read_weights(obj, names).values()], axis=0)
    mesh = meshes.read_mesh(obj)
    n = len(mesh.rest_positions)
    first, second = face_edges(mesh.corner_vertices, mesh.face_sizes)
    if obj.arap.join_seams:
        same = native.load().same_places(mesh.rest_positions, mesh.corner_vertices, mesh.face_sizes)
        first, second = np.concatenate([first, np.arange(n)]), np.concatenate([second, same])
    labels = connected_labels(n, first, second)
    is_unheld = ~np.isin(labels, labels[is_held])
    is_in_face = np.zeros(n, dtype=bool)
    is_in_face[mesh.corner_vertices] = True
    n_parts = len(np.unique(labels[is_unheld & is_in_face]))
    return np.flatnonzero(is_unheld).astype(np.int32), n_parts
