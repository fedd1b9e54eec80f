# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves the objects and bones of handles by a motion since rest."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Matrix

from ..core.arrays import Floats
from ..core.transforms import inverted
from . import handle_motion, meshes, ui_cache

if TYPE_CHECKING:
    from ..props.controls import ArapControl

# How far a motion may be from the wanted one. For its shift: as seen, as a fraction of the diagonal.
AT_PLACE = 1e-4


def reset_handles(obj: bpy.types.Object) -> list[str]:
    """Puts every handle's object or bone back to its place at rest, and pins added to a pose hold the rest shape.

    Returns:
        Names of the handles that something else (animation, a constraint, a driver) keeps elsewhere.
    """
    meshes.check_mesh(obj)
    forget_bases(obj)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return place_handles(obj, {i: np.eye(4) for i in working_handles(obj, depsgraph)})


def forget_bases(obj: bpy.types.Object) -> None:
    """Lets all pins and handles hold the mesh as it is at rest."""
    for control in obj.arap.controls:
        control.forget_base()


def working_handles(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> list[int]:
    """Indices in the list of controls of what can be moved, enabled or not."""
    made: handle_motion.Made = {}
    handles = ((i, control) for i, control in enumerate(obj.arap.controls) if not control.is_pin)
    return [i for i, handle in handles if not handle_motion.problem_of(obj, handle, depsgraph, made)]


def place_handles(obj: bpy.types.Object, motions: Mapping[int, Floats]) -> list[str]:
    """Moves the objects and bones of handles.

    Args:
        motions: (4, 4) object-space motion since rest, by index in the list of controls; of working handles.

    Returns:
        Names of the handles that something else (animation, a constraint, a driver, a sheared parent) keeps
        elsewhere.

    Raises:
        ValueError: a motion is damaged, or the mesh or the armature of a bone is scaled to nothing.
    """
    for index, motion in motions.items():
        if not np.isfinite(motion).all():
            name = obj.arap.controls[index].name
            raise ValueError(f"The stored motion of handle '{name}' is damaged: store the pose again")
    by_depth: dict[int, list[int]] = {}
    for index in motions:
        handle = obj.arap.controls[index]
        by_depth.setdefault(_depth(handle.target, handle.bone), []).append(index)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    # Parents first: a child's new transform is relative to the new place of its parent.
    for depth in sorted(by_depth):
        world = handle_motion.object_matrix(obj, depsgraph)
        for index in by_depth[depth]:
            handle = obj.arap.controls[index]
            _move(handle, world @ motions[index] @ np.array(handle.rest, dtype=np.float64), depsgraph)
        depsgraph = bpy.context.evaluated_depsgraph_get()
    if not motions:
        return []
    stretch, tolerance = meshes.read_stretch(obj, depsgraph), AT_PLACE * ui_cache.diagonal(obj, depsgraph)
    world, held = handle_motion.object_matrix(obj, depsgraph), []
    for index, motion in motions.items():
        handle = obj.arap.controls[index]
        if not _is_same(handle_motion.motion_of(handle, depsgraph, world), motion, handle, stretch, tolerance):
            held.append(handle.name)
    return held


def _move(handle: ArapControl, matrix: Floats, depsgraph: bpy.types.Depsgraph) -> None:
    """To a (4, 4) world matrix."""
    if handle.bone:
        armature = handle_motion.object_matrix(handle.target, depsgraph)  # refuses a flat one
        handle.target.pose.bones[handle.bone].matrix = Matrix(inverted(armature) @ matrix)
    else:
        handle.target.matrix_world = Matrix(matrix)


def _depth(target: bpy.types.Object, bone: str) -> int:
    """How many parents it has: bones count the bones above them and their armature, objects their parents."""
    depth = 1 + len(target.pose.bones[bone].parent_recursive) if bone else 0
    if target.parent is None:
        return depth
    on_bone = target.parent_bone if target.parent_type == "BONE" and target.parent.pose else ""
    return depth + 1 + _depth(target.parent, on_bone if on_bone and on_bone in target.parent.pose.bones else "")


def _is_same(motion: Floats, wanted: Floats, handle: ArapControl, stretch: Floats, tolerance: float) -> bool:
    if np.abs(motion - wanted)[:3, :3].max() > AT_PLACE * max(1.0, np.abs(wanted[:3, :3]).max()):
        return False
    place = np.array([*handle.rest.translation, 1.0])
    return bool(np.abs(stretch @ ((motion - wanted) @ place)[:3]).max() <= tolerance)
