# SPDX-License-Identifier: GPL-3.0-or-later
"""The patch that a point handle of the scene holds, before there is a session that knows it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import native
from ..core.patches import local_patch, neighbourhood, reaches_of_points, surface_diagonal
from ..core.targets import HandleSpec, Patch
from . import handle_motion, meshes
from .inputs import settings_of, spec_of

if TYPE_CHECKING:
    from ..props.handles import ArapHandle


def find_patch(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    vertices: NDArray[np.int32],
    besides: ArapHandle | None = None,
    *,
    use_nodes: bool | None = None,
) -> Patch | None:
    """What a handle that is not exact would hold in place of ``vertices``; None: the vertices themselves.

    Args:
        obj: the mesh.
        depsgraph: for its scale.
        vertices: (k,), all of weight 1.
        besides: the handle of these vertices, where there is one already.
        use_nodes: see versions.read_group_weights().
    """
    settings = settings_of(obj)
    if not settings.has_radius or native.problem():
        return None
    mesh = meshes.read_mesh(obj)
    stretch = meshes.read_stretch(obj, depsgraph)
    seen = mesh.rest_positions @ stretch.T
    radius = settings.rigidity_radius * surface_diagonal(seen, mesh.corner_vertices)
    has_face = np.zeros(len(seen), dtype=bool)
    has_face[mesh.corner_vertices] = True
    faceless = np.flatnonzero(~has_face).astype(np.int32)

    spec = HandleSpec("", vertices, np.ones(len(vertices)), is_exact=False)
    reach = reaches_of_points([spec], mesh.rest_positions, stretch, radius, faceless).get(0)
    if reach is None:
        return None
    specs = [spec, *_other_specs(obj, besides, use_nodes)]
    reach = reaches_of_points(specs, mesh.rest_positions, stretch, radius, faceless).get(0)
    if reach is None:
        return None
    part = neighbourhood(seen, mesh.corner_vertices, mesh.face_sizes, vertices, reach)
    return local_patch(
        native.load(),
        mesh.rest_positions,
        part,
        vertices,
        reach,
        stretch,
        weights=settings.weights,
        join_seams=settings.join_seams,
    )


def _other_specs(obj: bpy.types.Object, besides: ArapHandle | None, use_nodes: bool | None) -> list[HandleSpec]:
    holds = [hold for hold in handle_motion.enabled_holds(obj, besides) if hold[0] in obj.vertex_groups]
    weights = meshes.read_weights(obj, sorted({group for group, _ in holds}), use_nodes=use_nodes)
    return [spec_of(hold, weights[hold[0]]) for hold in holds]
