# SPDX-License-Identifier: GPL-3.0-or-later
"""Which mesh an object moves as a handle.

The answer is kept until handles or the objects of the scene change: panels, polls and drawing ask many times in each
redraw, and only a look at every object of the scene can say "none".
"""

from __future__ import annotations

import bpy

from ..props import hooks

_owners: dict[tuple[str, str, str], str] = {}
"""Name of the mesh, '' if there is none, by names of scene, view layer and moving object."""


def is_moved_by(obj: bpy.types.Object, target: bpy.types.Object) -> bool:
    """Whether ``obj`` is a mesh with ``target``, or a bone of it, as a handle."""
    return obj.type == "MESH" and any(handle.target == target for handle in obj.arap.handles)


def find(view_layer: bpy.types.ViewLayer, target: bpy.types.Object) -> bpy.types.Object | None:
    """A mesh in the view layer that ``target`` moves, None if there is none.

    It is right after Blender has evaluated the scene, as it does before it draws.
    """
    key = (view_layer.id_data.name_full, view_layer.name, target.name_full)
    name = _owners.get(key)
    if name == "":
        return None
    owner = view_layer.objects.get(name) if name else None
    if owner is None or not is_moved_by(owner, target):
        owner = next((obj for obj in view_layer.objects if is_moved_by(obj, target)), None)
        _owners[key] = owner.name if owner is not None else ""
    return owner


def forget_updated(depsgraph: bpy.types.Depsgraph) -> None:
    """After an evaluation: forgets everything if objects may have come into the scene or have other names."""
    if _owners and any(map(_may_change_owners, depsgraph.updates)):
        _owners.clear()


def _may_change_owners(update: bpy.types.DepsgraphUpdate) -> bool:
    if isinstance(update.id, bpy.types.Object):
        return not (update.is_updated_geometry or update.is_updated_transform)
    return isinstance(update.id, (bpy.types.Scene, bpy.types.Collection))


def clear() -> None:
    """Forgets everything: another file, an undo, or another object of a handle."""
    _owners.clear()


def _on_handle_changed(_obj: bpy.types.Object, _handle: object) -> None:
    clear()


CALLBACKS = ((hooks.handle_changed, _on_handle_changed),)
