# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's scene: objects from arrays and arrays from objects."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy
import numpy as np
from measure.base.contender import Floats, Ints
from measure.base.workers import NotRun

from .printed import Printed


def clear() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)


def new_mesh(name: str, positions: Floats, corner_vertices: Ints, face_sizes: Ints) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(len(positions))
    mesh.loops.add(len(corner_vertices))
    mesh.loops.foreach_set("vertex_index", corner_vertices)
    mesh.polygons.add(len(face_sizes))
    mesh.polygons.foreach_set("loop_start", np.cumsum(face_sizes) - face_sizes)
    mesh.vertices.foreach_set("co", single(positions))
    mesh.update(calc_edges=True)
    mesh.validate()
    return linked(name, mesh)


def new_armature(bones: Floats) -> bpy.types.Object:
    """With bones (b, 2, 3), head and tail, that have no parents, in this order."""
    armature = linked("Armature", bpy.data.armatures.new("Armature"))
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for k, (head, tail) in enumerate(bones):
        bone = armature.data.edit_bones.new(f"Bone {k:04d}")
        bone.head, bone.tail = head, tail
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def linked(name: str, data: bpy.types.ID) -> bpy.types.Object:
    made = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(made)
    return made


def bind(modified: bpy.types.Object, modifier: bpy.types.Modifier, operator: Callable[..., Any], says: str) -> None:
    """By the modifier's operator; ``says`` is the attribute that tells whether it has bound.

    Raises:
        NotRun: it has not.
    """
    bpy.context.view_layer.objects.active = modified
    bpy.context.view_layer.update()
    with Printed() as printed:
        operator(modifier=modifier.name)
    if not getattr(modifier, says):
        reason = printed.after(f'Modifier: "{modifier.name}", ') or "it does not say why"
        raise NotRun(f"{modifier.name} does not bind: {reason}")


def move_vertices(moved: bpy.types.Object, places: Floats) -> None:
    moved.data.vertices.foreach_set("co", single(places))
    moved.data.update()


def evaluated(modified: bpy.types.Object) -> Floats:
    """(n, 3) positions behind all modifiers."""
    return positions_of(behind_modifiers(modified))


def arrays(modified: bpy.types.Object) -> tuple[Floats, Ints, Ints]:
    """Positions (n, 3), corner vertices (c,) and face sizes (f,) behind all modifiers."""
    mesh = behind_modifiers(modified)
    corners, sizes = np.empty(len(mesh.loops), dtype=np.int32), np.empty(len(mesh.polygons), dtype=np.int32)
    mesh.loops.foreach_get("vertex_index", corners)
    mesh.polygons.foreach_get("loop_total", sizes)
    return positions_of(mesh), corners, sizes


def behind_modifiers(modified: bpy.types.Object) -> bpy.types.Mesh:
    return modified.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


def positions_of(mesh: bpy.types.Mesh) -> Floats:
    found = np.empty(3 * len(mesh.vertices), dtype=np.float32)
    mesh.vertices.foreach_get("co", found)
    return found.reshape(-1, 3).astype(np.float64)


def single(positions: Floats) -> np.typing.NDArray[np.float32]:
    return positions.astype(np.float32).ravel()
