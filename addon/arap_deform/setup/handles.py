# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of an object: added and removed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Matrix

from ..core import naming, native
from ..core.arrays import Floats, Ints
from ..core.patches import diagonal_of
from ..core.targets import HandleSpec
from ..core.transforms import inverted, transformed
from ..scene import groups, handle_motion, meshes, pose_key, remembered, staying
from ..scene.groups import VertexIndices
from ..scene.held import HeldMesh, fit
from . import made_objects
from .handle_changes import making, take_over
from .pins import GroupList, count_rows

if TYPE_CHECKING:
    from ..props.handles import ArapHandle

SMALLEST_HANDLE = 0.02  # radius of an empty for a tiny group, as a fraction of the mesh's diagonal

HANDLES = GroupList("handle", "handles", "active_handle_index", "vertex_group")


def add_handle(
    obj: bpy.types.Object,
    vertices: VertexIndices,
    name: str = "Handle",
    location: Sequence[float] | None = None,
    *,
    is_exact: bool = False,
) -> ArapHandle:
    """Makes a vertex group of ``vertices`` (weight 1) and an empty that moves it.

    The empty is at the group's centroid (or at ``location``, world space), has the size of the group, and is a child of
    the object, in one of the object's enabled collections. On a posed mesh it is at the posed centroid, and the mesh
    does not move.

    With the energy "rotation_nodes" a handle smaller than the rigidity radius holds the average of a round patch around
    its vertices, and its empty is there. With ``is_exact`` it holds the vertices themselves.
    """
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    indices = groups.checked_indices(obj, vertices)
    if location is not None and np.shape(location) != (3,):
        raise ValueError(f"The location of handle '{name}' has shape {np.shape(location)}: give x, y and z")
    depsgraph = meshes.depsgraph_with(obj)
    world = handle_motion.object_matrix(obj, depsgraph)
    rest = meshes.read_rest(obj)
    found = fit(HeldMesh(obj, depsgraph), HandleSpec(name, indices, np.ones(len(indices)), is_exact))
    motion = world @ found.motion @ inverted(world)

    points = transformed(world, rest[indices])
    centre = points.mean(axis=0) if found.centre is None else transformed(world, found.centre)
    if location is not None:
        centre = transformed(inverted(motion), np.array([location], dtype=np.float64))[0]
    at_rest = np.eye(4)
    at_rest[:3, 3] = centre

    with making():
        handle = new_handle(obj, groups.new(obj, indices, name), name)
        handle.is_exact = is_exact
        handle.target = made_objects.new_empty(obj, name, world, motion @ at_rest)
        handle.has_made_group = handle.has_made_target = True  # last: setting group and target clears these
        handle.rest = Matrix(inverted(world) @ at_rest)
        handle.group_radius = max(
            float(np.linalg.norm(points - points.mean(axis=0), axis=1).max()),
            SMALLEST_HANDLE * diagonal_of(transformed(world, rest)),
        )
    staying.stay(obj, None, handle)
    made_objects.resize_empty(obj, handle)
    return handle


def add_handle_for(
    obj: bpy.types.Object, target: bpy.types.Object, bone: str = "", radius: float | None = None
) -> ArapHandle:
    """Makes a handle for an existing object, or a bone of an armature, with a vertex group of its own.

    Args:
        target: the object, or the armature of ``bone``.
        bone: name of a pose bone, '' for the object itself.
        radius: world units. The group has the vertices whose posed place is within this distance of the target's
            origin (the bone's head). If there are none, or if ``radius`` is None, it has the nearest vertex.
    """
    return add_handles_for(obj, [(target, bone)], radius)[0]


def add_handles_for(
    obj: bpy.types.Object, targets: Sequence[tuple[bpy.types.Object, str]], radius: float | None = None
) -> list[ArapHandle]:
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
        take_over(obj, *obj.arap.handles[first:])
    return list(obj.arap.handles[first:])


@contextmanager
def all_or_none(obj: bpy.types.Object) -> Iterator[int]:
    """While handles are added, from the index that it yields on: if one cannot be, none is."""
    first, active, bases = len(obj.arap.handles), obj.arap.active_handle_index, staying.capture_bases(obj)
    try:
        yield first
    except BaseException:
        for index in reversed(range(first, len(obj.arap.handles))):
            remove_handle(obj, index)
        obj.arap.active_handle_index = active
        staying.restore_bases(obj, bases)
        raise


def _vertices_around(shown: Floats, place: Floats, radius: float | None) -> Ints:
    distance = np.linalg.norm(shown - place, axis=1)
    within = np.flatnonzero(distance <= radius) if radius is not None else ()
    return np.asarray(within if len(within) else [int(distance.argmin())], dtype=np.int32)


def _add_around(obj: bpy.types.Object, target: bpy.types.Object, bone: str, vertices: Ints) -> None:
    name = bone or target.name
    with making():
        handle = new_handle(obj, groups.new(obj, vertices, name), name)
        handle.has_made_group = True
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


def new_handle(obj: bpy.types.Object, group: str, name: str) -> ArapHandle:
    handles = obj.arap.handles
    unique_name = naming.unique(name, {handle.name for handle in handles})
    handle: ArapHandle = handles.add()
    handle.name = unique_name
    handle.vertex_group = group
    count_rows(obj)
    obj.arap.active_handle_index = len(handles) - 1
    return handle


def remove_handle(obj: bpy.types.Object, index: int) -> None:
    """Removes a handle, and the vertex group and the empty made for it if nothing else uses them."""
    handle = HANDLES.at(obj, index)
    target = handle.target if handle.has_made_target else None
    if target is not None and target.mode != "OBJECT":
        raise ValueError(f"'{target.name}' is in another mode: go back to Object Mode first")
    HANDLES.remove(obj, index)
    if target is not None:
        made_objects.remove_unused(target)


def handle_problem(obj: bpy.types.Object, index: int, *, with_weights: bool = False) -> str:
    """Why a handle cannot work (no object, object deleted, bone or group missing ...), one sentence; '' if it can.

    Args:
        index: of the handle.
        with_weights: report a group without weights too, if a look at it takes only milliseconds: see remembered.
    """
    handle = HANDLES.at(obj, index)
    problem = handle_motion.problem_of(obj, handle, meshes.drawn_depsgraph(bpy.context))
    if not problem and with_weights and remembered.is_empty_group(obj, handle.vertex_group):
        return handle_motion.no_weights(obj, handle)
    return problem
