# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of an object: added."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import bpy
import numpy as np
from mathutils import Matrix

from ..core import native
from ..core.arrays import Floats, Ints
from ..core.patches import diagonal_of
from ..core.targets import HandleSpec
from ..core.transforms import inverted, transformed
from ..scene import groups, handle_motion, meshes, pose_key, preserve_shape
from ..scene.constraint_preview import ConstraintPreview, place_handle
from ..scene.groups import VertexIndices
from . import made_objects
from .control_changes import rebase, suppress_updates
from .controls import all_or_none, new_control

SMALLEST_HANDLE = 0.02  # radius of an empty for a tiny group, as a fraction of the mesh's diagonal


def add_handle(
    obj: bpy.types.Object,
    vertices: VertexIndices,
    name: str = "Handle",
    location: Sequence[float] | None = None,
    *,
    use_exact: bool = False,
) -> str:
    """Makes a vertex group of ``vertices`` (weight 1) and an empty that moves it; the name of the handle.

    The empty is at the group's centroid (or at ``location``, world space), has the size of the group, and is a child of
    the object, in one of the object's enabled collections. On a posed mesh it is at the posed centroid, and the mesh
    does not move.

    With the energy "rotation_nodes" a handle smaller than the rigidity radius holds the average of a round patch around
    its vertices, and its empty is there. With ``use_exact`` it holds the vertices themselves.
    """
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    indices = groups.checked_indices(obj, vertices)
    if location is not None and np.shape(location) != (3,):
        raise ValueError(f"The location of handle '{name}' has shape {np.shape(location)}: give x, y and z")
    depsgraph = meshes.depsgraph_with(obj)
    world = handle_motion.object_matrix(obj, depsgraph)
    rest = meshes.read_rest(obj)
    found = place_handle(ConstraintPreview(obj, depsgraph), HandleSpec(name, indices, np.ones(len(indices)), use_exact))
    motion = world @ found.motion @ inverted(world)

    points = transformed(world, rest[indices])
    centre = points.mean(axis=0) if found.centre is None else transformed(world, found.centre)
    if location is not None:
        centre = transformed(inverted(motion), np.array([location], dtype=np.float64))[0]
    at_rest = np.eye(4)
    at_rest[:3, 3] = centre

    handle = new_control(obj, "handle", name, groups.new(obj, indices, name))
    with suppress_updates():
        handle.use_exact = use_exact
        handle.target = made_objects.new_empty(obj, name, world, motion @ at_rest)
        handle.has_made_group = handle.has_made_target = True  # last: setting group and target clears these
        handle.rest = Matrix(inverted(world) @ at_rest)
        handle.group_radius = max(
            float(np.linalg.norm(points - points.mean(axis=0), axis=1).max()),
            SMALLEST_HANDLE * diagonal_of(transformed(world, rest)),
        )
    preserve_shape.keep_shown_shape(obj, None, handle)
    made_objects.resize_empty(obj, handle)
    return str(handle.name)


def add_handle_for(obj: bpy.types.Object, target: bpy.types.Object, bone: str = "", radius: float | None = None) -> str:
    """Makes a handle for an existing object, or a bone of an armature, with a vertex group of its own; its name.

    Args:
        target: the object, or the armature of ``bone``.
        bone: name of a pose bone, '' for the object itself.
        radius: world units. The group has the vertices whose posed place is within this distance of the target's
            origin (the bone's head). If there are none, or if ``radius`` is None, it has the nearest vertex.
    """
    return add_handles_for(obj, [(target, bone)], radius)[0]


def add_handles_for(
    obj: bpy.types.Object, targets: Sequence[tuple[bpy.types.Object, str]], radius: float | None = None
) -> list[str]:
    """add_handle_for() each of ``targets``, an object and a bone's name ('' for the object itself); all or none."""
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    if not targets:
        raise ValueError(f"'{obj.name}' has no objects to take as handles: select some besides the mesh")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for target, bone in targets:
        reason = handle_motion.target_problem(obj, target, bone, depsgraph)
        if reason:
            raise ValueError(f"'{obj.name}' cannot take the handle: {reason}")
    world = handle_motion.object_matrix(obj, depsgraph)
    shown = transformed(world, pose_key.shown_positions(obj, meshes.read_rest(obj)))
    places = [handle_motion.target_matrix(target, bone, depsgraph)[:3, 3] for target, bone in targets]
    with all_or_none(obj) as first:
        for (target, bone), place in zip(targets, places, strict=True):
            _add_around(obj, target, bone, _vertices_around(shown, place, radius))
        rebase(obj, *obj.arap.controls[first:])
    return [str(handle.name) for handle in obj.arap.controls[first:]]


def _vertices_around(shown: Floats, place: Floats, radius: float | None) -> Ints:
    distance = np.linalg.norm(shown - place, axis=1)
    within = np.flatnonzero(distance <= radius) if radius is not None else ()
    return np.asarray(within if len(within) else [int(distance.argmin())], dtype=np.int32)


def _add_around(obj: bpy.types.Object, target: bpy.types.Object, bone: str, vertices: Ints) -> None:
    name = bone or target.name
    handle = new_control(obj, "handle", name, groups.new(obj, vertices, name))
    handle.has_made_group = True
    with suppress_updates():
        handle.target = target
        handle.bone = bone


@contextmanager
def following_first_handle(obj: bpy.types.Object) -> Iterator[None]:
    """The artist adds handles: the mesh follows from its first one on.

    If Follow was switched off later, another handle leaves it so.
    """
    is_first = not obj.arap.handles
    yield
    if is_first and obj.arap.handles and not native.problem():
        obj.arap.use_follow = True
