# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that are made for handles: where they are put, how large empties are, and when they go with their handle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy
from mathutils import Matrix

from ..core.arrays import Floats
from ..core.transforms import inverted
from ..props import hooks
from ..props.bounds import bounded
from ..scene import handle_motion, meshes

if TYPE_CHECKING:
    from ..props.controls import ArapControl


def new_empty(obj: bpy.types.Object, name: str, world: Floats, matrix: Floats) -> bpy.types.Object:
    empty = bpy.data.objects.new(name, None)
    collection_for_made(obj).objects.link(empty)
    empty.empty_display_type = "SPHERE"
    empty.show_in_front = True
    empty.parent = obj
    # Cancels the parent's matrix of now: the empty's axes are the world's, even under a stretched object.
    empty.matrix_parent_inverse = Matrix(inverted(world))
    empty.matrix_world = Matrix(matrix)  # unlike matrix_basis, it can be read before the next evaluation
    return empty


def collection_for_made(obj: bpy.types.Object) -> bpy.types.Collection:
    """A local, enabled collection of the object, else the scene's."""
    users = obj.users_collection
    for collection in meshes.enabled_collections(bpy.context.view_layer.layer_collection):
        if collection in users and collection.library is None and not meshes.is_override(collection):
            return collection
    return bpy.context.scene.collection


def resize_empties(obj: bpy.types.Object) -> None:
    """Gives the empties that were made for handles the size set in ``obj.arap``."""
    made: handle_motion.Made = {}
    for handle in obj.arap.handles:
        if handle.has_made_target and handle.target is not None and not handle_motion.other_owner(obj, handle, made):
            resize_empty(obj, handle)


def resize_empty(obj: bpy.types.Object, handle: ArapControl) -> None:
    """The same for one, whose empty is there."""
    handle.target.empty_display_size = bounded(obj.arap, "handle_size") * bounded(handle, "group_radius")


def remove_unused(target: bpy.types.Object) -> None:
    """Removes an empty that was made for a handle, if nothing else uses it."""
    if not _is_used(target):
        bpy.data.objects.remove(target)


def _is_used(target: bpy.types.Object) -> bool:
    """Whether other data (children, constraints, handles of other meshes) uses it."""
    users = bpy.data.user_map(subset=[target])[target]
    # Scenes and collections only show it.
    return any(not isinstance(user, (bpy.types.Scene, bpy.types.Collection)) for user in users)


CALLBACKS = ((hooks.display_changed, resize_empties),)
