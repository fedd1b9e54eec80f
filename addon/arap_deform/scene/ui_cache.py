# SPDX-License-Identifier: GPL-3.0-or-later
"""What panels, polls and drawing ask at each redraw: groups without weights, sizes, and which mesh an object moves.

An answer is kept until something changes it. It is right after Blender has evaluated the scene, as it does before it
draws.
"""

from __future__ import annotations

import bpy
import numpy as np

from ..core import sessions
from ..core.arrays import Floats
from ..core.mirror import seen_size
from ..props import hooks
from . import handle_motion, known, meshes, versions

# With more vertices the look takes longer than a panel may. Then preparing the pose tells of empty groups.
MOST_VERTICES = 20_000
SAME_STRETCH = 1e-5  # relative; the matrix of a turning object differs by less

_has_weights: dict[int, dict[str, bool]] = {}
"""By uid of the object and name of the group."""
_sizes: dict[int, tuple[Floats, float]] = {}
"""The stretch, scaled to a largest entry of 1, and the diagonal under it, by uid of the object."""
_has_foreign: dict[tuple[int, int], bool] = {}
_targets: dict[tuple[int, int], set[int]] = {}
"""Uids of the objects of its handles. Both by uid of the mesh and its number of handles: to remove one evaluates
nothing."""
_owners: dict[tuple[int, str, int], int] = {}
"""Uid of the mesh, 0 if there is none, by scene, view layer and moving object."""
_in_hand: dict[tuple[int, str], int] = {}
"""Uid of the mesh that panels showed last, by scene and view layer. An undo leaves it in hand."""


def is_empty_group(obj: bpy.types.Object, group: str) -> bool:
    """Whether no vertex has weight in the group; False too if the look would take more than milliseconds."""
    if obj.mode != "OBJECT" or group not in obj.vertex_groups or len(obj.data.vertices) > MOST_VERTICES:
        return False
    if group not in _has_weights.get(obj.session_uid, {}):
        # All groups at once. Not by nodes: they add to the scene, and drawing must not.
        weights = versions.read_group_weights(obj, obj.vertex_groups.keys(), use_nodes=False)
        _has_weights[known.add(obj)] = {name: bool(values.any()) for name, values in weights.items()}
    return not _has_weights[obj.session_uid][group]


def diagonal(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> float:
    """Diagonal of the box of the vertices that are in faces, at rest and with the object's stretch, in scene units.

    Of half a mesh with a Mirror modifier: that of both halves.

    Raises:
        ValueError: the object is scaled to nothing.
    """
    stretch = meshes.read_stretch(obj, depsgraph)
    scale = float(np.abs(stretch).max())
    shape = stretch / scale
    former = _sizes.get(obj.session_uid)
    if former is None or np.abs(former[0] - shape).max() > SAME_STRETCH:
        mesh = meshes.read_mesh(obj)
        mirrors = meshes.read_mirrors(obj, depsgraph, shape, mesh.rest_positions)
        former = (shape, seen_size(mesh, mirrors, shape))
        _sizes[known.add(obj)] = former
    return scale * former[1]


def has_foreign_handles(obj: bpy.types.Object) -> bool:
    """Whether there are handle_motion.foreign_handles(): that takes a look at every object of the file."""
    key = obj.session_uid, len(obj.arap.controls)
    if key not in _has_foreign:
        _has_foreign[key] = bool(handle_motion.foreign_handles(obj))
    return _has_foreign[key]


def is_moved_by(obj: bpy.types.Object, target: bpy.types.Object) -> bool:
    """Whether ``obj`` is a mesh with ``target``, or a bone of it, as a handle."""
    if obj.type != "MESH":
        return False
    key = obj.session_uid, len(obj.arap.controls)
    if key not in _targets:
        _targets[key] = {handle.target.session_uid for handle in obj.arap.handles if handle.target is not None}
    return target.session_uid in _targets[key]


def owner_of(view_layer: bpy.types.ViewLayer, target: bpy.types.Object) -> bpy.types.Object | None:
    """A mesh in the view layer that ``target`` moves, None if there is none. Of several the one in hand."""
    if not known.any_objects():
        return None
    layer = (view_layer.id_data.session_uid, view_layer.name)
    key = (*layer, target.session_uid)
    uid = _owners.get(key)
    if uid == 0:
        return None
    for last in (_in_hand.get(layer), uid):
        owner = known.find_in(view_layer, last) if last is not None and known.is_known(last) else None
        if owner is not None and is_moved_by(owner, target):
            return owner
    owners = (obj for obj in known.all_objects() if is_moved_by(obj, target) and known.is_in(view_layer, obj))
    owner = next(owners, None)
    _owners[key] = 0 if owner is None else owner.session_uid
    return owner


def set_panel_object(view_layer: bpy.types.ViewLayer, obj: bpy.types.Object) -> None:
    """Panels show this mesh, and go on to do so while an object is picked that moves it."""
    _in_hand[view_layer.id_data.session_uid, view_layer.name] = obj.session_uid


def forget_updated(update: known.Update) -> None:
    """After an evaluation: forgets what has changed. While a task has the mesh, its rest shape stays."""
    if update.is_deformed:
        _has_weights.pop(update.uid, None)
        if update.uid not in sessions.locks:
            _sizes.pop(update.uid, None)


def forget_handles(*, has_new_objects: bool) -> None:
    """After an evaluation: handles may have other objects."""
    _has_foreign.clear()
    _targets.clear()
    if has_new_objects:
        _owners.clear()


def clear() -> None:
    """Forgets everything: another file, or an undo."""
    for answers in (_has_weights, _sizes, _has_foreign, _targets, _owners):
        answers.clear()


def _on_control_changed(obj: bpy.types.Object, _control: object) -> None:
    known.add(obj)
    forget_handles(has_new_objects=True)


CALLBACKS = ((hooks.control_changed, _on_control_changed),)


def unregister() -> None:
    clear()
    _in_hand.clear()
