# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffness of an object: entries added and removed. And the soft edge of a vertex group."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core.distance import distances_within, faded
from ..scene import groups, meshes
from ..scene.groups import VertexIndices
from .pins import GroupList

if TYPE_CHECKING:
    from ..props.handles import ArapStiffness

STIFFNESS = GroupList("stiffness", "stiffness", "active_stiffness_index")


def add_stiffness(
    obj: bpy.types.Object, vertices: VertexIndices, name: str = "Stiff", factor: float = 100.0
) -> ArapStiffness:
    """Makes a vertex group of ``vertices`` (weight 1), ``factor`` (1 to 100) times as stiff as the rest."""
    if not 1.0 <= factor <= 100.0:
        raise ValueError(f"factor = {factor}, must be 1 to 100")
    entry: ArapStiffness = STIFFNESS.add_vertices(obj, vertices, name)
    entry.factor = factor
    return entry


def add_rigid(
    obj: bpy.types.Object, vertices: VertexIndices, name: str = "Rigid", *, is_one_body: bool = False
) -> ArapStiffness:
    """Makes a vertex group of ``vertices`` that keeps its shape.

    Each connected piece moves as one body, for example each of two shoes. With ``is_one_body`` all pieces move as one
    body, for example the shells of a helmet.
    """
    entry: ArapStiffness = STIFFNESS.add_vertices(obj, vertices, name)
    entry.is_rigid, entry.is_one_body = True, is_one_body
    return entry


def add_stiffness_group(obj: bpy.types.Object, vertex_group: str) -> ArapStiffness:
    """Adds an existing vertex group to the list. If it is there already, returns that entry, enabled."""
    entry: ArapStiffness = STIFFNESS.add_group(obj, vertex_group)
    return entry


def remove_stiffness(obj: bpy.types.Object, index: int) -> None:
    """Removes an entry, and its vertex group if the entry made it and nothing else uses it."""
    STIFFNESS.remove(obj, index)


def soften_group(obj: bpy.types.Object, vertex_group: str, radius: float) -> None:
    """Fades a group out smoothly around its vertices of weight 1, to 0 at the distance ``radius``.

    All weights below 1 are replaced: the result depends only on the vertices of weight 1 and the radius.

    Args:
        vertex_group: the name of its group.
        radius: along the surface at rest, in world units. 0 makes a hard edge.

    Raises:
        ValueError: the mesh cannot be used, has no such group, or no vertex of weight 1; or the radius is negative.
    """
    meshes.check_mesh(obj)
    groups.check(obj, vertex_group)
    if not radius >= 0.0:
        raise ValueError(f"radius = {radius}, must be 0 or more")
    before = meshes.read_weights(obj, [vertex_group])[vertex_group]
    sources = np.flatnonzero(before >= 1.0).astype(np.int32)
    if not len(sources):
        raise ValueError(f"Vertex group '{vertex_group}' of '{obj.name}' has no vertex of weight 1: paint some first")
    mesh = meshes.read_mesh(obj)
    stretch = meshes.read_stretch(obj, bpy.context.evaluated_depsgraph_get())
    seen = mesh.rest_positions @ stretch.T
    weights = faded(distances_within(seen, mesh.corner_vertices, mesh.face_sizes, sources, radius), radius)
    weights[sources] = 1.0
    changed = np.flatnonzero((weights != before) & ((weights > 0.0) | (before > 0.0))).astype(np.int32)
    groups.write(obj, vertex_group, changed, weights[changed])
