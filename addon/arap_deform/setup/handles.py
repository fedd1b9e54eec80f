# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of an object: added, changed, removed."""

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
from ..core.transforms import transformed
from ..props import hooks
from ..props.bounds import bounded
from ..scene import groups, handle_motion, meshes, remembered, staying
from ..scene.cages import place as cages
from ..scene.groups import VertexIndices
from ..scene.held import HeldMesh, fit
from ..scene.inputs import has_group
from .pins import GroupList, count_rows

if TYPE_CHECKING:
    from ..props.handles import ArapHandle
    from ..scene.held import Entry

SMALLEST_HANDLE = 0.02  # radius of an empty for a tiny group, as a fraction of the mesh's diagonal

HANDLES = GroupList("handle", "handles", "active_handle_index", "vertex_group")

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
    depsgraph = bpy.context.evaluated_depsgraph_get()
    world = handle_motion.object_matrix(obj, depsgraph)
    rest = meshes.read_rest(obj)
    found = fit(HeldMesh(obj, depsgraph), HandleSpec(name, indices, np.ones(len(indices)), is_exact))
    motion = world @ found.motion @ np.linalg.inv(world)

    points = transformed(world, rest[indices])
    centre = points.mean(axis=0) if found.centre is None else transformed(world, found.centre)
    if location is not None:
        centre = transformed(np.linalg.inv(motion), np.array([location], dtype=np.float64))[0]
    at_rest = np.eye(4)
    at_rest[:3, 3] = centre

    with making():
        handle = new_handle(obj, groups.new(obj, indices, name), name)
        handle.is_exact = is_exact
        handle.target = _new_empty(obj, name, world, motion @ at_rest)
        handle.has_made_group = handle.has_made_target = True  # last: setting group and target clears these
        handle.rest = Matrix(np.linalg.inv(world) @ at_rest)
        handle.group_radius = max(
            float(np.linalg.norm(points - points.mean(axis=0), axis=1).max()),
            SMALLEST_HANDLE * diagonal_of(transformed(world, rest)),
        )
    staying.stay(obj, bpy.context.evaluated_depsgraph_get(), handle)
    resize_empties(obj)
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
    shown = transformed(world, handle_motion.shown_positions(obj, meshes.read_rest(obj)))
    places = [handle_motion.target_matrix(target, bone, depsgraph)[:3, 3] for target, bone in targets]
    with all_or_none(obj) as first:
        for (target, bone), place in zip(targets, places, strict=True):
            _add_around(obj, target, bone, _vertices_around(shown, place, radius))
        take_over(obj, *obj.arap.handles[first:])
    return list(obj.arap.handles[first:])


@contextmanager
def all_or_none(obj: bpy.types.Object) -> Iterator[int]:
    """While handles are added, from the index that it yields on: if one cannot be, none is."""
    first, active, shapes = len(obj.arap.handles), obj.arap.active_handle_index, staying.capture_shapes(obj)
    try:
        yield first
    except BaseException:
        for index in reversed(range(first, len(obj.arap.handles))):
            remove_handle(obj, index)
        obj.arap.active_handle_index = active
        staying.restore_shapes(obj, shapes)
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
        obj.arap.is_live = True


def remove_handle(obj: bpy.types.Object, index: int) -> None:
    """Removes a handle, and the vertex group and the empty or cage made for it if nothing else uses them."""
    handle = HANDLES.at(obj, index)
    target = handle.target if handle.has_made_target else None
    if target is not None and target.mode != "OBJECT":
        raise ValueError(f"'{target.name}' is in another mode: go back to Object Mode first")
    HANDLES.remove(obj, index)
    if target is not None and not _is_used(target):
        mesh = target.data if target.type == "MESH" else None  # of a cage; an empty may show an image of the artist's
        bpy.data.objects.remove(target)
        if mesh is not None and not mesh.users:
            bpy.data.meshes.remove(mesh)


def take_over(obj: bpy.types.Object, *entries: Entry) -> None:
    """Lets pins and handles hold the pose shown now, wherever the objects of handles are: the mesh must not jump.

    But bones without a vertex group: the mesh at rest has their armature at rest.

    Called after a change of a handle's target, bone or group. Passes over entries of which one of these is missing.
    """
    if obj.type != "MESH":
        return
    depsgraph = bpy.context.evaluated_depsgraph_get()
    use_nodes = False if obj.mode == "EDIT" else None  # nodes would read the mesh that is being edited
    for entry in entries:
        if hasattr(entry, "target") and entry.is_cage and not _lack_of_target(obj, entry, depsgraph):
            cages.take_over(obj, entry, depsgraph)
    whole = [entry for entry in entries if not _lack_of(obj, entry, depsgraph)]
    _set_rests(obj, [entry for entry in whole if hasattr(entry, "target")], depsgraph, use_nodes)
    staying.stay(obj, depsgraph, *whole, use_nodes=use_nodes)


def _lack_of(obj: bpy.types.Object, entry: Entry, depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether its group or its object is missing. A cage has no group."""
    if hasattr(entry, "target") and _lack_of_target(obj, entry, depsgraph):
        return True
    return not has_group(obj, entry)


def _lack_of_target(obj: bpy.types.Object, handle: ArapHandle, depsgraph: bpy.types.Depsgraph) -> bool:
    if handle_motion.target_problem(obj, handle.target, handle.bone, depsgraph):
        return True
    return bool(handle.is_cage and handle.target.type != "MESH")


def _set_rests(
    obj: bpy.types.Object, handles: Sequence[ArapHandle], depsgraph: bpy.types.Depsgraph, use_nodes: bool | None
) -> None:
    """Sets the rest matrices of handles so that the places of their objects now give the pose shown now."""
    if not handles:
        return
    inverse = np.linalg.inv(handle_motion.object_matrix(obj, depsgraph))
    motions = np.tile(np.eye(4), (len(handles), 1, 1))
    if handle_motion.pose_key_of(obj) is not None:
        held = HeldMesh(obj, depsgraph, use_nodes=use_nodes)
        for i, (handle, spec) in enumerate(zip(handles, held.specs_of(handles), strict=True)):
            if len(spec.vertices):
                motions[i] = fit(held, spec, handle).motion
    for handle, motion in zip(handles, motions, strict=True):
        if handle.is_bone_alone:
            matrix = handle_motion.bone_rest_matrix(handle.target, handle.bone, depsgraph)
        else:
            matrix = handle_motion.target_matrix(handle.target, handle.bone, depsgraph)
        handle.rest = Matrix(np.linalg.inv(motion) @ inverse @ matrix)


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


def resize_empties(obj: bpy.types.Object) -> None:
    """Gives the empties that were made for handles the size set in ``obj.arap``."""
    made: handle_motion.Made = {}
    for handle in obj.arap.handles:
        if handle.has_made_target and handle.target is not None and not handle_motion.other_owner(obj, handle, made):
            handle.target.empty_display_size = bounded(obj.arap, "handle_size") * bounded(handle, "group_radius")


@contextmanager
def making() -> Iterator[None]:
    """While a function fills in a handle: its steps are not choices of the artist."""
    global _is_making  # noqa: PLW0603 - Blender's update callbacks take no other message
    _is_making = True
    try:
        yield
    finally:
        _is_making = False


def new_handle(obj: bpy.types.Object, group: str, name: str) -> ArapHandle:
    handles = obj.arap.handles
    unique_name = naming.unique(name, {handle.name for handle in handles})
    handle: ArapHandle = handles.add()
    handle.name = unique_name
    handle.vertex_group = group
    count_rows(obj)
    obj.arap.active_handle_index = len(handles) - 1
    return handle


def _new_empty(obj: bpy.types.Object, name: str, world: Floats, matrix: Floats) -> bpy.types.Object:
    empty = bpy.data.objects.new(name, None)
    collection_for_made(obj).objects.link(empty)
    empty.empty_display_type = "SPHERE"
    empty.show_in_front = True
    empty.parent = obj
    # Cancels the parent's matrix of now: the empty's axes are the world's, even under a stretched object.
    empty.matrix_parent_inverse = Matrix(np.linalg.inv(world))
    empty.matrix_world = Matrix(matrix)  # unlike matrix_basis, it can be read before the next evaluation
    return empty


def collection_for_made(obj: bpy.types.Object) -> bpy.types.Collection:
    """A local, enabled collection of the object, else the scene's."""
    users = obj.users_collection
    for collection in meshes.enabled_collections(bpy.context.view_layer.layer_collection):
        if collection in users and collection.library is None and not meshes.is_override(collection):
            return collection
    return bpy.context.scene.collection


def _is_used(empty: bpy.types.Object) -> bool:
    """Whether other data (children, constraints, handles of other meshes) uses the empty."""
    users = bpy.data.user_map(subset=[empty])[empty]
    # Scenes and collections only show it.
    return any(not isinstance(user, (bpy.types.Scene, bpy.types.Collection)) for user in users)


def _on_changed(obj: bpy.types.Object, handle: ArapHandle) -> None:
    if _is_making:
        return
    try:
        take_over(obj, handle)
    except ValueError:
        handle.rest_matrix = (0.0,) * 16  # the rest place is unknown, which handle_problem() reports


def _on_renamed(obj: bpy.types.Object, handle: ArapHandle) -> None:
    """Gives the empty and the vertex group that were made for a handle its new name."""
    name = naming.cut(handle.name)
    if name and handle.has_made_group:
        with making():
            handle.vertex_group = groups.rename(obj, handle.vertex_group, name)
            handle.has_made_group = True  # last: setting the group clears it
    if name and handle.has_made_target and handle.target and not handle_motion.other_owner(obj, handle):
        handle.target.name = name


CALLBACKS = (
    (hooks.handle_changed, _on_changed),
    (hooks.handle_renamed, _on_renamed),
    (hooks.display_changed, resize_empties),
)
