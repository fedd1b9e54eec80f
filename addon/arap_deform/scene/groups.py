# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertex groups of an object: made, checked, written in bulk, removed. Blender refuses all this in Edit Mode."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import naming
from ..core.arrays import Floats, Ints
from . import versions

VertexIndices = Sequence[int] | NDArray[np.integer]

# One call of Blender writes one weight to many vertices. So weights are written in steps as fine as its fields show.
WEIGHT_STEPS = 1000


def checked_indices(obj: bpy.types.Object, vertices: VertexIndices) -> Ints:
    """(k,) int32 ascending. Raises ValueError if there are none, or one that the mesh does not have."""
    indices: NDArray[np.integer] = np.unique(np.asarray(vertices))
    n = len(obj.data.vertices)
    if not indices.size:
        raise ValueError(f"No vertices of '{obj.name}' were given: select some")
    if indices.dtype.kind not in "iu":
        raise ValueError(f"Vertices of '{obj.name}' must be whole numbers, not {indices.dtype}")
    if indices[0] < 0 or indices[-1] >= n:
        wrong = indices[0] if indices[0] < 0 else indices[-1]
        raise ValueError(f"'{obj.name}' has no vertex {wrong}: its vertices are 0 to {n - 1}")
    return indices.astype(np.int32)


def check(obj: bpy.types.Object, name: str) -> None:
    """Raises ValueError if the object has no such group."""
    if name not in obj.vertex_groups:
        raise ValueError(f"'{obj.name}' has no vertex group '{name}': choose one of its groups")


def new(obj: bpy.types.Object, indices: Ints, name: str) -> str:
    """A new group of these vertices, weight 1; its name, numbered if a group has it, or a bone that would take it."""
    taken = {*obj.vertex_groups.keys(), *_names_of_bones(obj)}
    group = obj.vertex_groups.new(name=naming.unique(name, taken))
    group.add(indices.tolist(), 1.0, "REPLACE")
    return str(group.name)


def _names_of_bones(obj: bpy.types.Object) -> set[str]:
    """Of the armatures that the object is skinned to: a group of such a name would be moved by the bone."""
    rigs = [modifier.object for modifier in obj.modifiers if modifier.type == "ARMATURE" and modifier.object]
    return {bone.name for rig in rigs for bone in rig.data.bones}


def write(obj: bpy.types.Object, name: str, vertices: Ints, weights: Floats) -> None:
    """Gives (k,) ``vertices`` these weights, in steps of 1 / WEIGHT_STEPS; 0 takes them out of the group.

    A weight below 1 stays below 1: weight 1 holds a vertex exactly, less holds it softly.
    """
    if not len(vertices):
        return
    group = obj.vertex_groups[name]
    steps = np.rint(weights * WEIGHT_STEPS).astype(np.int64)
    steps[weights < 1.0] = np.minimum(steps[weights < 1.0], WEIGHT_STEPS - 1)
    order = np.argsort(steps, kind="stable")
    levels, starts = np.unique(steps[order], return_index=True)
    for level, of_level in zip(levels.tolist(), np.split(vertices[order], starts[1:]), strict=True):
        if level:
            group.add(of_level.tolist(), level / WEIGHT_STEPS, "REPLACE")
        else:
            group.remove(of_level.tolist())
    obj.data.update_tag()


def remove_unused(obj: bpy.types.Object, name: str) -> None:
    """Removes a group if nothing of the object uses it any more. Does nothing for ''."""
    group = obj.vertex_groups.get(name) if name else None
    if group is not None and name not in _used_names(obj):
        obj.vertex_groups.remove(group)


def rename(obj: bpy.types.Object, name: str, wanted: str) -> str:
    """Renames a group unless several users know it by its name; the name that it has then.

    Blender numbers a name that another group has. Objects that share a mesh share the names of its groups.
    """
    group = obj.vertex_groups.get(name)
    if group is None or obj.data.users > 1 or sum(used == name for used in _used_names(obj)) > 1:
        return name
    group.name = wanted
    return str(group.name)


def _used_names(obj: bpy.types.Object) -> Iterator[str]:
    """Names of the groups that the object uses, once for each use."""
    settings = obj.arap
    yield from (entry.name for entry in settings.stiffness)
    yield from (control.vertex_group for control in settings.controls)
    yield from (key.vertex_group for key in (obj.data.shape_keys.key_blocks if obj.data.shape_keys else ()))
    for modifier in obj.modifiers:
        yield from _groups_of_modifier(modifier)


def _groups_of_modifier(modifier: bpy.types.Modifier) -> Iterator[str]:
    """Names of the groups that a modifier uses: itself, in its settings (cloth), as its particles or its nodes."""
    yield from _group_fields(modifier)
    for name, field in modifier.bl_rna.properties.items():
        settings = getattr(modifier, name) if field.type == "POINTER" and name != "rna_type" else None
        if settings is not None and not isinstance(settings, bpy.types.ID):
            yield from _group_fields(settings)
    if modifier.type == "NODES":
        yield from versions.node_attributes(modifier)


def _group_fields(data: bpy.types.bpy_struct) -> Iterator[str]:
    for name, field in data.bl_rna.properties.items():
        if field.type == "STRING" and "vertex_group" in name:
            yield getattr(data, name)
