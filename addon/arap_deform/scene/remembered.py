# SPDX-License-Identifier: GPL-3.0-or-later
"""What panels, polls and drawing ask at each redraw: groups without weights, sizes, and which mesh an object moves.

An answer is kept until something changes it. It is right after Blender has evaluated the scene, as it does before it
draws. Objects are known by their full names: a linked one may have the name of a local one.
"""

from __future__ import annotations

from collections.abc import Container

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.mirror import seen_size
from ..props import hooks
from . import handle_motion, meshes, versions

# With more vertices the look takes longer than a panel may. Then preparing the pose tells of empty groups.
MOST_VERTICES = 20_000
SAME_STRETCH = 1e-5  # relative; the matrix of a turning object differs by less

_has_weights: dict[str, dict[str, bool]] = {}
"""By names of objects and of groups."""
_sizes: dict[str, tuple[Floats, float]] = {}
"""The stretch, scaled to a largest entry of 1, and the diagonal under it."""
_has_foreign: dict[tuple[str, int], bool] = {}
_targets: dict[tuple[str, int], set[int]] = {}
"""Addresses of the objects of its handles. Both by name of the mesh and its number of handles: to remove one evaluates
nothing."""
_owners: dict[tuple[str, str, str], str] = {}
"""Name of the mesh, '' if there is none, by names of scene, view layer and moving object."""
_in_hand: dict[tuple[str, str], str] = {}
"""Name of the mesh that panels showed last, by names of scene and view layer. An undo leaves it in hand."""


def is_empty_group(obj: bpy.types.Object, group: str) -> bool:
    """Whether no vertex has weight in the group; False too if the look would take more than milliseconds."""
    if obj.mode != "OBJECT" or group not in obj.vertex_groups or len(obj.data.vertices) > MOST_VERTICES:
        return False
    if group not in _has_weights.get(obj.name_full, {}):
        # All groups at once. Not by nodes: they add to the scene, and drawing must not.
        weights = versions.read_group_weights(obj, obj.vertex_groups.keys(), use_nodes=False)
        _has_weights[obj.name_full] = {name: bool(values.any()) for name, values in weights.items()}
    return not _has_weights[obj.name_full][group]


def diagonal(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> float:
    """Diagonal of the box of the vertices that are in faces, at rest and with the object's stretch, in scene units.

    Of half a mesh with a Mirror modifier: that of both halves.

    Raises:
        ValueError: the object is scaled to nothing.
    """
    stretch = meshes.read_stretch(obj, depsgraph)
    scale = float(np.abs(stretch).max())
    shape = stretch / scale
    former = _sizes.get(obj.name_full)
    if former is None or np.abs(former[0] - shape).max() > SAME_STRETCH:
        mesh = meshes.read_mesh(obj)
        mirrors = meshes.read_mirrors(obj, depsgraph, shape, mesh.rest_positions)
        former = (shape, seen_size(mesh, mirrors, shape))
        _sizes[obj.name_full] = former
    return scale * former[1]


def has_foreign_handles(obj: bpy.types.Object) -> bool:
    """Whether there are handle_motion.foreign_handles(): that takes a look at every object of the file."""
    key = obj.name_full, len(obj.arap.handles)
    if key not in _has_foreign:
        _has_foreign[key] = bool(handle_motion.foreign_handles(obj))
    return _has_foreign[key]


def is_moved_by(obj: bpy.types.Object, target: bpy.types.Object) -> bool:
    """Whether ``obj`` is a mesh with ``target``, or a bone of it, as a handle."""
    if obj.type != "MESH":
        return False
    key = obj.name_full, len(obj.arap.handles)
    if key not in _targets:
        _targets[key] = {handle.target.as_pointer() for handle in obj.arap.handles if handle.target is not None}
    return target.as_pointer() in _targets[key]


def owner_of(view_layer: bpy.types.ViewLayer, target: bpy.types.Object) -> bpy.types.Object | None:
    """A mesh in the view layer that ``target`` moves, None if there is none. Of several the one in hand.

    Only a look at every object of the scene can say "none".
    """
    layer = (view_layer.id_data.name_full, view_layer.name)
    key = (*layer, target.name_full)
    name = _owners.get(key)
    if name == "":
        return None
    in_hand = view_layer.objects.get(_in_hand.get(layer, ""))
    if in_hand is not None and is_moved_by(in_hand, target):
        return in_hand
    owner = view_layer.objects.get(name) if name else None
    if owner is None or not is_moved_by(owner, target):
        owner = next((obj for obj in view_layer.objects if is_moved_by(obj, target)), None)
        _owners[key] = owner.name if owner is not None else ""
    return owner


def take_in_hand(view_layer: bpy.types.ViewLayer, obj: bpy.types.Object) -> None:
    """Panels show this mesh, and go on to do so while an object is picked that moves it."""
    _in_hand[view_layer.id_data.name_full, view_layer.name] = obj.name


def forget_updated(depsgraph: bpy.types.Depsgraph, posed: Container[str]) -> None:
    """After an evaluation: forgets what has changed, except the sizes of ``posed`` objects: their rest shape stays."""
    _has_foreign.clear()
    _targets.clear()
    if not (_has_weights or _sizes or _owners):
        return
    for update in depsgraph.updates:
        if isinstance(update.id, bpy.types.Object) and update.is_updated_geometry:
            _has_weights.pop(update.id.name_full, None)
            if update.id.name_full not in posed:  # acts have objects of this file, whose full name is their name
                _sizes.pop(update.id.name_full, None)
        if _may_change_owners(update):
            _owners.clear()


def _may_change_owners(update: bpy.types.DepsgraphUpdate) -> bool:
    """Whether objects may have come into the scene or have other names."""
    if isinstance(update.id, bpy.types.Object):
        return not (update.is_updated_geometry or update.is_updated_transform)
    return isinstance(update.id, (bpy.types.Scene, bpy.types.Collection))


def clear() -> None:
    """Forgets everything: another file, or an undo."""
    for answers in (_has_weights, _sizes, _has_foreign, _targets, _owners):
        answers.clear()


def _on_handle_changed(_obj: bpy.types.Object, _handle: object) -> None:
    _has_foreign.clear()
    _targets.clear()
    _owners.clear()


CALLBACKS = ((hooks.handle_changed, _on_handle_changed),)


def unregister() -> None:
    clear()
    _in_hand.clear()
