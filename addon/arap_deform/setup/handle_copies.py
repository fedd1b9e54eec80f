# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles of its own for a copy of a mesh, whose handles are still the empties of the original."""

from __future__ import annotations

import bpy
from mathutils import Matrix

from ..core.transforms import inverted
from ..scene import handle_motion, meshes
from .control_changes import suppress_updates
from .made_objects import collection_for_made


def copy_handles(obj: bpy.types.Object) -> list[bpy.types.Object]:
    """Copies the empties of the original, with their animation, to the same places on this mesh.

    Empties of its own that are in no scene, as if they were deleted, are put into that of the mesh.

    Returns:
        The empties that are new in the scene.

    Raises:
        ValueError: all handles are its own already and in a scene, or the mesh is linked.
    """
    meshes.check_local(obj)
    handles = handle_motion.foreign_handles(obj)
    if not handles:
        raise ValueError(f"'{obj.name}' has handles of its own, and none was deleted: there is nothing to copy")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    made: handle_motion.Made = {}
    owners = {handle.target: handle_motion.other_owner(obj, handle, made) for handle in handles}
    for mesh in (obj, *filter(None, owners.values())):
        handle_motion.object_matrix(mesh, depsgraph)  # refuses a flat mesh before anything is copied
    twins = {target: _copied(target) if owner else target for target, owner in owners.items()}
    for target, owner in owners.items():
        if owner is not None:
            _take_along(twins[target], target, owner, obj, twins, depsgraph)
    collection = collection_for_made(obj)
    for twin in twins.values():
        collection.objects.link(twin)
    with suppress_updates():
        for handle in handles:
            handle.target = twins[handle.target]
            handle.has_made_target = True  # last: setting the target clears it
    obj.arap.follow_error = ""
    return list(twins.values())


def _copied(target: bpy.types.Object) -> bpy.types.Object:
    """With an animation of its own. An image that it shows both may show."""
    twin = target.copy()
    animation = twin.animation_data
    if animation is not None and animation.action is not None:
        animation.action = animation.action.copy()
    return twin


def _take_along(
    twin: bpy.types.Object,
    target: bpy.types.Object,
    owner: bpy.types.Object,
    obj: bpy.types.Object,
    twins: dict[bpy.types.Object, bpy.types.Object],
    depsgraph: bpy.types.Depsgraph,
) -> None:
    """Makes ``twin`` a child of ``obj``, or of another twin, as ``target`` is one of ``owner``."""
    twin.parent = twins.get(target.parent, obj)
    if target.parent == owner or target.parent in twins:
        return  # the same place relative to the parent is the same place on the mesh
    world, of_owner = meshes.read_matrix(obj, depsgraph), meshes.read_matrix(owner, depsgraph)
    twin.parent_type = "OBJECT"
    twin.matrix_parent_inverse = Matrix(inverted(world))
    twin.matrix_world = Matrix(world @ inverted(of_owner) @ meshes.read_matrix(target, depsgraph))
