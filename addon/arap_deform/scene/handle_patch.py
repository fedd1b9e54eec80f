# SPDX-License-Identifier: GPL-3.0-or-later
"""The patch of a point handle, before there is a session that knows it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import native
from ..core.patches import local_patch, neighbourhood, reaches_of_points, surface_diagonal
from ..core.targets import HandleSpec, Patch
from . import meshes
from .inputs import enabled_holds, settings_of, spec_of

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
    """The patch that a handle of these vertices would hold if it is not exact. None: it holds the vertices.

    Args:
        depsgraph: for its scale.
        vertices: (k,), all of weight 1.
        besides: the handle of these vertices, if there is one already.
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
        settings,
    )


def _other_specs(obj: bpy.types.Object, besides: ArapHandle | None, use_nodes: bool | None) -> list[HandleSpec]:
    holds = [hold for hold in enabled_holds(obj, besides) if hold.group in obj.vertex_groups]
    weights = meshes.read_weights(obj, sorted({hold.group for hold in holds}), use_nodes=use_nodes)
    return [spec_of(hold, weights[hold.group]) for hold in holds]
