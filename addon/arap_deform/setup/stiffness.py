# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffness of an object: entries made and removed; the edge of a group softened."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core.distance import distances_within, faded
from ..scene import groups, meshes
from ..scene.groups import VertexIndices
from .lists import GroupList

if TYPE_CHECKING:
    from ..props.stiffness import ArapStiffness

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

    Each connected piece moves as one body: two shoes go their own ways. ``is_one_body``: all of it together, also
    pieces that are not joined, as the shells of a helmet.
    """
    entry: ArapStiffness = STIFFNESS.add_vertices(obj, vertices, name)
    entry.is_rigid, entry.is_one_body = True, is_one_body
    return entry


def add_stiffness_group(obj: bpy.types.Object, vertex_group: str) -> ArapStiffness:
    """Puts an existing vertex group on the list; where it is there already, returns that entry, enabled."""
    entry: ArapStiffness = STIFFNESS.add_group(obj, vertex_group)
    return entry


def remove_stiffness(obj: bpy.types.Object, index: int) -> None:
    """Takes an entry off the list, and its vertex group where the entry made it and nothing else uses it."""
    STIFFNESS.remove(obj, index)


def soften_group(obj: bpy.types.Object, vertex_group: str, radius: float) -> None:
    """Fades a group out around its vertices of weight 1, smoothly to 0 at ``radius`` from them.

    All weights below 1 are replaced, so that the result depends on these vertices and the radius alone; 0 makes the
    edge hard.

    Args:
        obj: the mesh.
        vertex_group: of it.
        radius: along the surface at rest, in world units as seen.

    Raises:
        ValueError: no mesh that can be used, no such group, a negative radius, or no vertex of weight 1.
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
