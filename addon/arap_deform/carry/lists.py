# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of followers: adds, places again, removes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Matrix

from ..core.arrays import Floats
from ..core.carry.pieces import looks_rigid
from ..core.patches import surface_diagonal
from ..core.transforms import transformed
from ..props.carry import KINDS
from ..scene import meshes, shape_keys
from ..scene.points import objects as points
from ..scene.seen import look
from . import late, problems, run, twins, wraps

if TYPE_CHECKING:
    from ..props.carry import ArapFollower

NAMES_OF_KINDS = [kind[0] for kind in KINDS]


def carry_along(
    body: bpy.types.Object, objects: Iterable[bpy.types.Object], kind: str = "", *, may_wait: bool = False
) -> list[ArapFollower]:
    """Makes meshes and curves go along with a mesh: clothes, hair, eyes.

    However the body is posed, each object gets a shape key of the same name and value. It is bound at rest, where it
    stands now relative to the body; call it again after either was moved to another place. If the body is posed, the
    objects go to the pose at once.

    Args:
        body: the mesh that they go along with.
        kind: "bend" or "rigid", where each loose piece keeps its shape; "": rigid if all pieces are small and compact,
            see looks_rigid(), and for an object that goes along already, as it is.
        may_wait: they are bound in the background, if there is a window.

    Returns:
        Their entries in ``body.arap.followers``.

    Raises:
        ValueError: an object cannot go along; then nothing has changed. RuntimeError: one cannot be bound.
    """
    meshes.check_mesh(body)
    meshes.check_local(body)
    if kind not in {"", *NAMES_OF_KINDS}:
        raise ValueError(f"kind = {kind!r}, must be 'bend' or 'rigid', or '' for the one that fits")
    targets = list(dict.fromkeys(objects))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for target in targets:
        problems.check_new(body, target, depsgraph)
        look.look(target, depsgraph)  # the list tells what it says
    places = [wraps.place_now(body, target, depsgraph) for target in targets]
    kinds = [kind] * len(targets) if kind else _looks(body, targets, places)
    for each in zip(targets, places, kinds, strict=True):
        _add(body, *each, is_set=bool(kind))
    added = [follower for follower in body.arap.followers if follower.target in targets]
    with wraps.reading_once():
        for follower in added:
            run.look_again(body, follower, may_wait=may_wait and not bpy.app.background)
    fault = next((late.faults[t.session_uid] for t in targets if t.session_uid in late.faults), "")
    if fault:
        raise RuntimeError(fault)
    return added


def stop_carrying(body: bpy.types.Object, obj: bpy.types.Object) -> None:
    """The object does not go along any more. The shape keys that were made for that are removed.

    Raises:
        ValueError: it does not go along, or is in Edit Mode.
    """
    follower = problems.entry_of(body, obj)
    if follower is None:
        raise ValueError(f"'{obj.name}' does not go along with '{body.name}'")
    remove_at(body, list(body.arap.followers).index(follower))


def remove_at(body: bpy.types.Object, index: int) -> None:
    """As stop_carrying(), by the number of the entry, whose object may be gone."""
    meshes.check_local(body)
    followers = body.arap.followers
    if not 0 <= index < len(followers):
        raise ValueError(f"'{body.name}' has no follower {index}: it has {len(followers)}")
    target = followers[index].target
    if target is not None and target.arap.carried.body == body and target.library is None:
        _release(target)
    followers.remove(index)
    body.arap.active_follower_index = max(0, min(body.arap.active_follower_index, len(followers) - 1))


def _looks(body: bpy.types.Object, targets: list[bpy.types.Object], places: list[Floats]) -> list[str]:
    """The kind of each that fits."""
    stretch = meshes.read_stretch(body, bpy.context.evaluated_depsgraph_get())
    mesh = meshes.read_mesh(body)
    size = surface_diagonal(mesh.rest_positions @ stretch.T, mesh.corner_vertices)
    kinds = []
    for target, place in zip(targets, places, strict=True):
        is_rigid = False
        if target.type == "MESH":  # the points of a curve do not tell how thick it is
            seen = transformed(place, meshes.read_rest(target).astype(np.float64)) @ stretch.T
            is_rigid = looks_rigid(seen, *meshes.read_faces(target.data), size)
        kinds.append("rigid" if is_rigid else "bend")
    return kinds


def _add(body: bpy.types.Object, target: bpy.types.Object, place: Floats, kind: str, *, is_set: bool) -> None:
    """``is_set``: the kind counts also for one that is in the list already."""
    follower = problems.entry_of(body, target)
    carried = target.arap.carried
    if carried.body not in {None, body}:
        _release(target)  # of a mesh that is gone, or of which the body is a copy
    carried.body = None  # until all is set: nothing is bound before
    if follower is None:
        follower = body.arap.followers.add()
        follower.target = target
        is_set = True
    if is_set:
        follower.kind = kind
    follower.is_enabled = True
    follower.set_place(Matrix(place))
    body.arap.active_follower_index = list(body.arap.followers).index(follower)
    if target.data.shape_keys is None:
        # Now, as a part of the step of undo that this is. Made later, it could be missing after an undo.
        shape_keys.ensure_reference(target)
        carried.has_made_reference = True
    carried.body = body


def _release(target: bpy.types.Object) -> None:
    """Takes back what was made on the object, and forgets with whom it went."""
    if points.has_points(target):
        if target.data.is_editmode:
            raise ValueError(f"'{target.name}' is in Edit Mode: go back to Object Mode first")
        twins.keep_only(target, ())
        if target.arap.carried.has_made_reference:
            shape_keys.remove_lone_reference(target)
    target.arap.carried.has_made_reference = False
    target.arap.carried.body = None
    run.forget(target.session_uid)
