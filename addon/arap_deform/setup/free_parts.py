# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices do not move: parts of the mesh without a pin or handle that follow none, and loose vertices."""

from __future__ import annotations

import bpy
import numpy as np

from ..core import native, sessions
from ..core.arrays import Ints
from ..core.graph import connected_labels, face_edges
from ..core.loose.binding import bind_loose_parts
from ..core.loose.pieces import joined_by_regions, numbered
from ..core.mirror import completed
from ..core.session import Session
from ..scene.inputs import read_input


def find(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> tuple[Ints, int]:
    """The vertices, (k,) int32 ascending, and how many parts of the mesh they are, loose ones not counted.

    Raises:
        ValueError: as read_input(), if the mesh cannot be used or has no pin and no handle.
        RuntimeError: the native module cannot be used.
    """
    inputs = read_input(obj, depsgraph)
    if any(spec.segment is not None for spec in inputs.specs):
        return _beside_bones(obj)
    mesh, whole = completed(inputs.mesh, inputs.mirrors, inputs.stretch)
    n, n_own = len(mesh.rest_positions), len(inputs.mesh.rest_positions)
    first, second = face_edges(mesh.corner_vertices, mesh.face_sizes)
    if inputs.settings.join_seams:
        same = native.load().same_places(mesh.rest_positions, mesh.corner_vertices, mesh.face_sizes)
        first, second = np.concatenate([first, np.arange(n)]), np.concatenate([second, same])
    labels = connected_labels(n, first, second)
    is_in_face = np.zeros(n, dtype=bool)
    is_in_face[mesh.corner_vertices] = True
    regions = inputs.rigid_regions if whole is None else whole.regions(inputs.rigid_regions)
    pieces = joined_by_regions(numbered(labels, is_in_face), regions)

    has_hold = np.isin(
        np.arange(n_own) if whole is None else whole.sources,
        np.concatenate([spec.vertices[spec.weights > 0.0] for spec in inputs.specs]),
    )
    is_held = np.zeros(int(pieces.max(initial=-1)) + 1, dtype=bool)
    is_held[pieces[has_hold & is_in_face]] = True
    is_free = np.append(~is_held, True)[pieces] & ~has_hold
    if inputs.settings.use_loose_parts:
        images = () if whole is None else whole.permutations()
        seen = mesh.rest_positions @ inputs.stretch.T
        loose = bind_loose_parts(seen, mesh.corner_vertices, mesh.face_sizes, pieces, is_held, images)
        if loose is not None:
            is_free[loose.vertices] = False
    n_parts = len(np.unique(labels[:n_own][(is_free & is_in_face)[:n_own]]))
    return np.flatnonzero(is_free[:n_own]).astype(np.int32), n_parts


def _beside_bones(obj: bpy.types.Object) -> tuple[Ints, int]:
    """As find(). Only a bound model knows what bones pass through."""
    bound = sessions.get(obj.session_uid)
    if bound is None or not isinstance(bound.session, Session) or sessions.stats(obj.session_uid) is None:
        raise ValueError(f"What bones move of '{obj.name}' is known once it was posed: tick Follow, or press Solve")
    return bound.session.at_rest
