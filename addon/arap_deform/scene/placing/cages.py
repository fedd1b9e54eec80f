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
from ...core.cages.shape import CageShape
from ...core.transforms import inverted
from .. import handle_motion, meshes, pose_key, versions
from ..cages import read, saved

if TYPE_CHECKING:
    from ...props.handles import ArapHandle

AT_REST = 1e-5  # as a fraction of the cage's size: as near as Blender's single precision brings it


@dataclass(frozen=True)
class CageState:
    """A cage and its rest; no Blender data.

    Attributes:
        target: uid of the object that the artist has chosen, 0 of a made one.
        rest: as saved: of its vertices for the mesh, of what is edited, and of its object.
        shape: what the artist edits; None if it cannot be edited.
    """

    target: int
    rest: tuple[str, str, tuple[float, ...]]
    shape: CageShape | None


def take_over(obj: bpy.types.Object, handle: ArapHandle, depsgraph: bpy.types.Depsgraph) -> None:
    """Makes the present shape of a cage its rest, at which the mesh is as it is shown now: it must not jump.

    One that cannot be a cage has no rest, and read.problem_of() says why.
    """
    read.flush(handle.target)
    if read.why_no_cage(obj, handle.target, depsgraph):
        saved.forget(handle)
        return
    world = handle_motion.object_matrix(obj, depsgraph)
    shape = _shape_of(handle.target)
    shown_keys = {name: of_key for name, of_key in shape.keys.items() if _is_shown(handle.target, name)}
    positions = read.evaluated_positions(handle.target, depsgraph, world)
    saved.save(handle, positions, CageShape(shape.positions, shown_keys))
    handle.rest = Matrix(inverted(world) @ meshes.read_matrix(handle.target, depsgraph))
    rest = meshes.read_rest(obj)
    shown = pose_key.shown_positions(obj, rest)
    if np.array_equal(shown, rest):
        handle.forget_shape()
    else:
        handle.set_shape(np.arange(len(rest), dtype=np.int32), shown - rest, len(rest))


def capture(obj: bpy.types.Object) -> dict[int, CageState]:
    """What restore() restores, by the numbers of the handles."""
    cages = [handle for handle in obj.arap.handles if handle.is_cage and handle.target is not None]
    return {
        cage.number: CageState(
            _chosen(cage),
            (cage.cage_text, cage.cage_shape_text, tuple(cage.rest_matrix)),
            _shape_of(cage.target) if _is_editable(cage) else None,
        )
        for cage in cages
    }


def restore(obj: bpy.types.Object, states: Mapping[int, CageState]) -> list[str]:
    """Puts cages and their rests back to what capture() returned. Passes over those for which another was chosen.

    Returns:
        Names of the cages that stay as they are, as they have other vertices or shape keys now.
    """
    stayed = []
    for handle in obj.arap.handles:
        state = states.get(handle.number) if handle.is_cage and handle.target is not None else None
        if state is None or state.target != _chosen(handle):
            continue
        if state.shape is not None and _is_editable(handle) and not _restore(handle.target, state.shape):
            stayed.append(handle.name)
        else:
            handle.cage_text, handle.cage_shape_text, handle.rest_matrix = state.rest
    return stayed


def _chosen(handle: ArapHandle) -> int:
    return 0 if handle.has_made_target else int(handle.target.session_uid)


def put_to_rest(obj: bpy.types.Object, handle: ArapHandle) -> bool:
    """Puts the object of a cage that works, and its vertices, back to rest.

    Shape keys that do not shape it at rest keep their offsets from it, and go to 0.

    Returns:
        Whether it is at rest now: a modifier, or an animation, may keep it elsewhere.
    """
    if _is_at_rest(obj, handle):
        return True
    world = handle_motion.object_matrix(obj, bpy.context.evaluated_depsgraph_get())
    handle.target.matrix_world = Matrix(world @ np.array(handle.rest, dtype=np.float64))
    shape = saved.shape_of(handle)
    if shape is not None and _is_editable(handle):
        _restore(handle.target, shape)
    return _is_at_rest(obj, handle)


def _is_at_rest(obj: bpy.types.Object, handle: ArapHandle) -> bool:
    depsgraph, rest = bpy.context.evaluated_depsgraph_get(), saved.rest_of(handle)
    now = read.evaluated_positions(handle.target, depsgraph, handle_motion.object_matrix(obj, depsgraph))
    return now.shape == rest.shape and bool(np.abs(now - rest).max() <= AT_REST * np.ptp(rest, axis=0).max())


def _is_editable(handle: ArapHandle) -> bool:
    target = handle.target
    return bool(handle.is_cage and target is not None and target.type == "MESH" and target.data.library is None)


def _shape_of(cage: bpy.types.Object) -> CageShape:
    read.flush(cage)
    keys = {key.name: (versions.read_key(key), key.value) for key in _other_keys(cage)}
    return CageShape(meshes.read_rest(cage), keys)


def _other_keys(cage: bpy.types.Object) -> list[bpy.types.ShapeKey]:
    """All but the reference."""
    return [] if cage.data.shape_keys is None else list(cage.data.shape_keys.key_blocks[1:])


def _is_shown(cage: bpy.types.Object, key: str) -> bool:
    """Whether the cage takes a shape from the key."""
    is_alone = cage.data.is_editmode or cage.show_only_shape_key  # the active key
    return bool(cage.data.shape_keys.key_blocks[key].value) or (is_alone and cage.active_shape_key.name == key)


def _restore(cage: bpy.types.Object, shape: CageShape) -> bool:
    """Restores the mesh and the keys of the shape; other keys keep their offsets, and go to 0.

    Returns:
        False if the cage has another number of vertices, or a key is gone; then nothing changes.
    """
    now = _shape_of(cage)
    if len(now.positions) != len(shape.positions) or not shape.keys.keys() <= now.keys.keys():
        return False
    shift = shape.positions - now.positions
    shapes = {name: shape.keys.get(name, (positions + shift, 0.0)) for name, (positions, _) in now.keys.items()}
    for key in _other_keys(cage):
        key.value = shapes[key.name][1]
    _write(cage, shape.positions, {name: positions for name, (positions, _) in shapes.items()})
    return True


def _write(cage: bpy.types.Object, positions: Float32s, of_keys: Mapping[str, Float32s]) -> None:
    mesh = cage.data
    if mesh.shape_keys is not None:
        of_keys = {mesh.shape_keys.reference_key.name: positions, **of_keys}
    if mesh.is_editmode:
        edited = bmesh.from_edit_mesh(mesh)
        layers = edited.verts.layers.shape
        shown = of_keys[cage.active_shape_key.name] if of_keys else positions
        for name in layers.keys() & of_keys.keys():  # else leaving Edit Mode brings the former ones back
            layer = layers[name]
            for vertex, position in zip(edited.verts, of_keys[name], strict=True):
                vertex[layer] = position
        for vertex, position in zip(edited.verts, shown, strict=True):
            vertex.co = position
        bmesh.update_edit_mesh(mesh)
    else:
        versions.write_positions(mesh, positions)
        for name, of_key in of_keys.items():
            versions.write_key(mesh.shape_keys.key_blocks[name], of_key)
    mesh.update_tag()
