# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of an object: making, removing, reading."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Matrix

from ..core import naming
from ..core.arrays import Floats
from ..core.patches import diagonal_of
from ..core.transforms import transformed
from ..props import hooks
from ..scene import empty_groups, groups, handle_motion, handle_patch, meshes
from ..scene.groups import VertexIndices
from .lists import item_at

if TYPE_CHECKING:
    from ..props.handles import ArapHandle

SMALLEST_HANDLE = 0.02  # radius of an empty for a tiny group, as a fraction of the mesh's diagonal

_is_making = False


def add_handle(
    obj: bpy.types.Object,
    vertices: VertexIndices,
    name: str = "Handle",
    location: Sequence[float] | None = None,
    *,
    is_exact: bool = False,
) -> ArapHandle:
    """Makes a vertex group of ``vertices`` (weight 1) and an empty that moves it.

    The empty stands at the group's centroid (or at ``location``, world space), sized to the group, in a collection of
    the object that is enabled, and is parented to the object, so that it goes where the object goes. On a posed mesh
    it stands where the pose has taken the group, and the mesh does not move.

    With the energy "rotation_nodes" a handle smaller than the rigidity radius holds the average of a round patch about
    its vertices, and its empty stands there; ``is_exact``: it holds the vertices themselves.
    """
    meshes.check_mesh(obj)
    indices = groups.checked_indices(obj, vertices)
    if location is not None and np.shape(location) != (3,):
        raise ValueError(f"The location of handle '{name}' has shape {np.shape(location)}: give x, y and z")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    world = handle_motion.object_matrix(obj, depsgraph)
    rest = meshes.read_rest(obj)
    patch = None if is_exact else handle_patch.find_patch(obj, depsgraph, indices)
    held = (indices, rest) if patch is None else (patch.vertices, rest, patch.weights)
    fit = world @ handle_motion.fit_to_pose(obj, depsgraph, *held) @ np.linalg.inv(world)

    points = transformed(world, rest[indices])
    centre = points.mean(axis=0) if patch is None else transformed(world, patch.centre)
    if location is not None:
        centre = transformed(np.linalg.inv(fit), np.array([location], dtype=np.float64))[0]
    at_rest = np.eye(4)
    at_rest[:3, 3] = centre

    with _making():
        handle = _new_handle(obj, groups.new(obj, indices, name), name)
        handle.is_exact = is_exact
        handle.target = _new_empty(obj, name, world, fit @ at_rest)
        handle.has_made_group = handle.has_made_target = True  # last: to be given one marks it as the artist's
        handle.rest = Matrix(np.linalg.inv(world) @ at_rest)
        handle.group_radius = max(
            float(np.linalg.norm(points - points.mean(axis=0), axis=1).max()),
            SMALLEST_HANDLE * diagonal_of(transformed(world, rest)),
        )
    update_handle_display(obj)
    return handle


def add_handle_for(
    obj: bpy.types.Object, target: bpy.types.Object, bone: str = "", radius: float | None = None
) -> ArapHandle:
    """Makes a handle for an existing object, or a bone of an armature, with a vertex group of its own.

    Args:
        obj: the mesh.
        target: the object, or the armature of ``bone``.
        bone: name of a pose bone, '' for the object itself.
        radius: world units; the group takes the vertices, as posed, within this distance of the target's origin
            (the bone's head), or the nearest one where there is none, or where ``radius`` is None.
    """
    meshes.check_mesh(obj)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    reason = handle_motion.target_problem(obj, target, bone, depsgraph)
    if reason:
        raise ValueError(f"'{obj.name}' cannot take the handle: {reason}")
    world = handle_motion.object_matrix(obj, depsgraph)
    shown = transformed(world, handle_motion.shown_positions(obj, meshes.read_rest(obj)))
    distance = np.linalg.norm(shown - handle_motion.target_matrix(target, bone, depsgraph)[:3, 3], axis=1)
    within = np.flatnonzero(distance <= radius) if radius is not None else ()
    indices = np.asarray(within if len(within) else [int(distance.argmin())], dtype=np.int32)
    name = bone or target.name
    with _making():
        handle = _new_handle(obj, groups.new(obj, indices, name), name)
        handle.has_made_group = True
        handle.target = target
        handle.bone = bone
    take_over(obj, handle)
    return handle


def add_handles_for(
    obj: bpy.types.Object, targets: Sequence[tuple[bpy.types.Object, str]], radius: float | None = None
) -> list[ArapHandle]:
    """add_handle_for() each of ``targets``, an object and a bone's name ('' for the object itself); all or none."""
    if not targets:
        raise ValueError(f"'{obj.name}' has no objects to take as handles: select some besides the mesh")
    first = len(obj.arap.handles)
    try:
        for target, bone in targets:
            add_handle_for(obj, target, bone, radius)
    except BaseException:
        for index in reversed(range(first, len(obj.arap.handles))):
            remove_handle(obj, index)
        raise
    return list(obj.arap.handles[first:])


def remove_handle(obj: bpy.types.Object, index: int) -> None:
    """Removes a handle, and the vertex group and the empty it made where nothing else uses them."""
    handles = obj.arap.handles
    handle = item_at(obj, handles, index, "handle")
    group = handle.vertex_group if handle.has_made_group else ""
    target = handle.target if handle.has_made_target else None
    handles.remove(index)
    obj.arap.active_handle_index = max(0, min(obj.arap.active_handle_index, len(handles) - 1))
    groups.remove_unused(obj, group)
    if target is not None and not _is_used(target):
        bpy.data.objects.remove(target)


def set_handle_target(obj: bpy.types.Object, index: int, target: bpy.types.Object, bone: str = "") -> None:
    """Gives a handle another object or bone. The mesh does not move: the new one takes over where it stands."""
    handle = item_at(obj, obj.arap.handles, index, "handle")
    reason = handle_motion.target_problem(obj, target, bone, bpy.context.evaluated_depsgraph_get())
    if reason:
        raise ValueError(f"Handle '{handle.name}' of '{obj.name}' cannot take it: {reason}")
    with _making():
        is_made = handle.has_made_target and handle.target == target
        handle.target = target
        handle.has_made_target = is_made
        handle.bone = bone
    take_over(obj, handle)


def set_handle_group(obj: bpy.types.Object, index: int, vertex_group: str) -> None:
    """Gives a handle another vertex group of ``obj``; the mesh does not move."""
    handle = item_at(obj, obj.arap.handles, index, "handle")
    groups.check(obj, vertex_group)
    with _making():
        is_made = handle.has_made_group and handle.vertex_group == vertex_group
        handle.vertex_group = vertex_group
        handle.has_made_group = is_made
    take_over(obj, handle)


def take_over(obj: bpy.types.Object, handle: ArapHandle) -> None:
    """Sets the handle's rest matrix so that the pose shown is the one its target stands for now.

    Called when somebody gives a handle another target, bone or group: the mesh must not jump. Does nothing while the
    handle lacks one of them.
    """
    if _is_making:
        return
    depsgraph = bpy.context.evaluated_depsgraph_get()
    is_whole = not handle_motion.target_problem(obj, handle.target, handle.bone, depsgraph)
    if obj.type != "MESH" or not is_whole or handle.vertex_group not in obj.vertex_groups:
        return
    world = handle_motion.object_matrix(obj, depsgraph)
    fit = np.eye(4)
    if handle_motion.pose_key_of(obj) is not None:
        rest = meshes.read_rest(obj)
        use_nodes = False if obj.mode == "EDIT" else None  # they would see the mesh that is being edited
        weights = meshes.read_weights(obj, [handle.vertex_group], use_nodes=use_nodes)[handle.vertex_group]
        indices = np.flatnonzero(weights > 0.0).astype(np.int32)
        is_point = not handle.is_exact and bool((weights[indices] >= 1.0).all())
        patch = handle_patch.find_patch(obj, depsgraph, indices, handle, use_nodes=use_nodes) if is_point else None
        held = (indices, rest) if patch is None else (patch.vertices, rest, patch.weights)
        if len(indices):
            fit = handle_motion.fit_to_pose(obj, depsgraph, *held)
    matrix = handle_motion.target_matrix(handle.target, handle.bone, depsgraph)
    handle.rest = Matrix(np.linalg.inv(fit) @ np.linalg.inv(world) @ matrix)


def handle_problem(obj: bpy.types.Object, index: int, *, with_weights: bool = False) -> str:
    """Why a handle cannot work (no object, object deleted, bone or group missing ...), one sentence; '' if it can.

    Args:
        obj: the mesh.
        index: of the handle.
        with_weights: say also where its group has no weights, as far as that takes milliseconds: see empty_groups.
    """
    handle = item_at(obj, obj.arap.handles, index, "handle")
    problem = handle_motion.problem_of(obj, handle, bpy.context.evaluated_depsgraph_get())
    if not problem and with_weights and empty_groups.is_empty(obj, handle.vertex_group):
        return handle_motion.no_weights(obj, handle)
    return problem


def update_handle_display(obj: bpy.types.Object) -> None:
    """Gives the empties that the handles made the shape, size and colour of ``obj.arap``."""
    settings = obj.arap
    for handle in settings.handles:
        if handle.has_made_target and handle.target is not None:
            handle.target.empty_display_type = settings.handle_shape
            handle.target.empty_display_size = settings.handle_size * handle.group_radius
            handle.target.show_in_front = settings.handle_in_front
            handle.target.color = settings.handle_color


@contextmanager
def _making() -> Iterator[None]:
    """While a function here fills in a handle, half of it must not be taken for the artist's choice."""
    global _is_making  # noqa: PLW0603 - Blender's update callbacks take no other message
    _is_making = True
    try:
        yield
    finally:
        _is_making = False


def _new_handle(obj: bpy.types.Object, group: str, name: str) -> ArapHandle:
    handles = obj.arap.handles
    unique_name = naming.unique(name, {handle.name for handle in handles})
    handle: ArapHandle = handles.add()
    handle.name = unique_name
    handle.vertex_group = group
    obj.arap.active_handle_index = len(handles) - 1
    return handle


def _new_empty(obj: bpy.types.Object, name: str, world: Floats, matrix: Floats) -> bpy.types.Object:
    empty = bpy.data.objects.new(name, None)
    _collection_for_empty(obj).objects.link(empty)
    empty.parent = obj
    # Undone by the parent's own matrix today: the empty's axes are the world's, even under a stretched object.
    empty.matrix_parent_inverse = Matrix(np.linalg.inv(world))
    empty.matrix_world = Matrix(matrix)  # not matrix_basis: this one can be read back before the next evaluation
    return empty


def _collection_for_empty(obj: bpy.types.Object) -> bpy.types.Collection:
    """One of the object's own, of those that Blender evaluates here and into which something can be put."""
    users = obj.users_collection
    for collection in meshes.enabled_collections(bpy.context.view_layer.layer_collection):
        if collection in users and collection.library is None and not meshes.is_override(collection):
            return collection
    return bpy.context.scene.collection


def _is_used(empty: bpy.types.Object) -> bool:
    """Whether other data (children, constraints, handles of other meshes) still refers to the empty."""
    users = bpy.data.user_map(subset=[empty])[empty]
    # The scene and the collections that show it are users too.
    return any(not isinstance(user, (bpy.types.Scene, bpy.types.Collection)) for user in users)


def _on_changed(obj: bpy.types.Object, handle: ArapHandle) -> None:
    try:
        take_over(obj, handle)
    except ValueError:
        handle.rest_matrix = (0.0,) * 16  # the place at rest cannot be told: handle_problem() says so


def register() -> None:
    hooks.handle_changed.append(_on_changed)
    hooks.display_changed.append(update_handle_display)


def unregister() -> None:
    hooks.display_changed.remove(update_handle_display)
    hooks.handle_changed.remove(_on_changed)
