# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiffness of an object: entries added and removed. And the soft edge of a vertex group."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..core.distance import distances_within, faded
from ..scene import groups, meshes
from ..scene.groups import VertexIndices

if TYPE_CHECKING:
    from ..props.controls import ArapStiffness


def add_stiffness(obj: bpy.types.Object, vertices: VertexIndices, name: str = "Stiff", factor: float = 100.0) -> str:
    """Makes a vertex group of ``vertices`` (weight 1), ``factor`` (1 to 100) times as stiff as the rest; its name."""
    if not 1.0 <= factor <= 100.0:
        raise ValueError(f"factor = {factor}, must be 1 to 100")
    entry = _add(obj, vertices, name)
    entry.factor = factor
    return str(entry.name)


def add_rigid(
    obj: bpy.types.Object, vertices: VertexIndices, name: str = "Rigid", *, use_single_body: bool = False
) -> str:
    """Makes a vertex group of ``vertices`` that keeps its shape; the name of the group.

    Each connected piece moves as one body, for example each of two shoes. With ``use_single_body`` all pieces move as
    one body, for example the shells of a helmet.
    """
    entry = _add(obj, vertices, name)
    entry.use_rigid, entry.use_single_body = True, use_single_body
    return str(entry.name)


def add_stiffness_group(obj: bpy.types.Object, vertex_group: str) -> str:
    """Adds an existing vertex group to the list; its name. An entry that is there already is chosen and enabled."""
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    groups.check(obj, vertex_group)
    return str(_entry_of(obj, vertex_group).name)


def _add(obj: bpy.types.Object, vertices: VertexIndices, name: str) -> ArapStiffness:
    """An entry with a vertex group of its own."""
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    entry = _entry_of(obj, groups.new(obj, groups.checked_indices(obj, vertices), name))
    entry.has_made_group = True
    return entry


def _entry_of(obj: bpy.types.Object, vertex_group: str) -> ArapStiffness:
    """Added if it is missing; enabled and chosen."""
    settings = obj.arap
    entry: ArapStiffness | None = settings.stiffness.get(vertex_group)
    if entry is None:
        entry = settings.stiffness.add()
        entry.name = vertex_group
    entry.is_enabled = True
    settings.active_stiffness_index = settings.stiffness.find(vertex_group)
    return entry


def remove_stiffness(obj: bpy.types.Object, vertex_group: str) -> None:
    """Removes the entry of a vertex group, and the group if it was made for the entry and nothing else uses it."""
    meshes.check_local(obj)
    settings = obj.arap
    index = settings.stiffness.find(vertex_group) if isinstance(vertex_group, str) else -1
    if index < 0:
        raise ValueError(f"'{obj.name}' has no stiffness of a vertex group {vertex_group!r}")
    made = vertex_group if settings.stiffness[index].has_made_group else ""
    settings.stiffness.remove(index)
    settings.active_stiffness_index = max(0, min(settings.active_stiffness_index, len(settings.stiffness) - 1))
    groups.remove_unused(obj, made)


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
