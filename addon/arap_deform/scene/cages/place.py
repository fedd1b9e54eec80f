# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets the rest of a cage, and puts its vertices back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import bmesh
import bpy
import numpy as np
from mathutils import Matrix

from ...core.arrays import Float32s
from ...core.transforms import transformed
from .. import handle_motion, meshes, versions
from . import read

if TYPE_CHECKING:
    from ...props.handles import ArapHandle

AT_REST = 1e-5  # as a fraction of the cage's size: as near as Blender's single precision brings it


@dataclass(frozen=True)
class CageShape:
    """What the artist edits of a cage; no Blender data.

    Attributes:
        positions: (c, 3) of the mesh itself.
        keys: (c, 3) of each shape key, by name, and its value.
    """

    positions: Float32s
    keys: Mapping[str, tuple[Float32s, float]]


def take_over(obj: bpy.types.Object, handle: ArapHandle, depsgraph: bpy.types.Depsgraph) -> None:
    """Makes the present shape of a cage its rest, at which the mesh is as it is shown now: it must not jump."""
    world = handle_motion.object_matrix(obj, depsgraph)
    if handle.target.data.is_editmode:
        handle.target.update_from_editmode()  # its faces are read from the mesh
    handle.set_cage_rest(read.evaluated_positions(handle.target, depsgraph, world))
    handle.rest = Matrix(np.linalg.inv(world) @ meshes.read_matrix(handle.target, depsgraph))
    rest = meshes.read_rest(obj)
    shown = handle_motion.shown_positions(obj, rest)
    if np.array_equal(shown, rest):
        handle.forget_shape()
    else:
        handle.set_shape(np.arange(len(rest), dtype=np.int32), shown - rest, len(rest))


def capture(obj: bpy.types.Object) -> dict[int, CageShape]:
    """The shapes of the cages of a mesh, by the numbers of their handles."""
    return {h.number: _shape_of(h.target) for h in obj.arap.handles if _is_editable(h)}


def restore(obj: bpy.types.Object, shapes: Mapping[int, CageShape]) -> None:
    """Restores what capture() returned. Passes over cages with another number of vertices."""
    for handle in obj.arap.handles:
        if _is_editable(handle) and handle.number in shapes:
            _restore(handle.target, shapes[handle.number])


def put_to_rest(obj: bpy.types.Object, handle: ArapHandle) -> bool:
    """Puts the object of a cage that works, and its vertices, back to rest. Shape keys go to 0.

    Returns:
        Whether it is at rest now: a modifier, or an animation, may keep it elsewhere.
    """
    target, rest = handle.target, handle.cage_rest
    depsgraph = bpy.context.evaluated_depsgraph_get()
    world = handle_motion.object_matrix(obj, depsgraph)
    target.matrix_world = Matrix(world @ np.array(handle.rest, dtype=np.float64))
    if _is_editable(handle):
        at_rest = np.array(handle.rest, dtype=np.float64)
        local = transformed(np.asarray(np.linalg.inv(at_rest)), rest).astype(np.float32)
        keys = target.data.shape_keys
        of_keys = {} if keys is None else {key.name: (versions.read_key(key), 0.0) for key in keys.key_blocks}
        if keys is not None:
            of_keys[keys.reference_key.name] = (local, keys.reference_key.value)
        _restore(target, CageShape(local, of_keys))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    now = read.evaluated_positions(target, depsgraph, handle_motion.object_matrix(obj, depsgraph))
    return now.shape == rest.shape and bool(np.abs(now - rest).max() <= AT_REST * np.ptp(rest, axis=0).max())


def _is_editable(handle: ArapHandle) -> bool:
    target = handle.target
    return bool(handle.is_cage and target is not None and target.type == "MESH" and target.data.library is None)


def _shape_of(cage: bpy.types.Object) -> CageShape:
    keys = {key.name: (versions.read_key(key), key.value) for key in _keys_of(cage)}
    if not cage.data.is_editmode:
        return CageShape(versions.read_positions(cage.data), keys)
    vertices = bmesh.from_edit_mesh(cage.data).verts
    positions = np.array([vertex.co for vertex in vertices], dtype=np.float32).reshape(-1, 3)
    if keys:  # what is edited is the active one
        keys[cage.active_shape_key.name] = (positions, cage.active_shape_key.value)
    return CageShape(positions, keys)


def _keys_of(cage: bpy.types.Object) -> list[bpy.types.ShapeKey]:
    return [] if cage.data.shape_keys is None else list(cage.data.shape_keys.key_blocks)


def _restore(cage: bpy.types.Object, shape: CageShape) -> None:
    keys = [key for key in _keys_of(cage) if key.name in shape.keys]
    for key in keys:
        key.value = shape.keys[key.name][1]
    if cage.data.is_editmode:
        active = cage.active_shape_key
        _write_edited(cage.data, shape.keys[active.name][0] if active in keys else shape.positions)
    elif len(cage.data.vertices) == len(shape.positions):
        versions.write_positions(cage.data, shape.positions)
        for key in keys:
            versions.write_key(key, shape.keys[key.name][0])
    cage.data.update_tag()


def _write_edited(mesh: bpy.types.Mesh, positions: Float32s) -> None:
    edited = bmesh.from_edit_mesh(mesh)
    if len(edited.verts) == len(positions):
        for vertex, position in zip(edited.verts, positions, strict=True):
            vertex.co = position
        bmesh.update_edit_mesh(mesh)
