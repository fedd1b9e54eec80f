# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of attachments of a host: attach, place again, detach."""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np
from mathutils import Matrix

from ..core.arrays import Floats
from ..core.attach.pieces import looks_rigid
from ..core.patches import surface_diagonal
from ..core.transforms import transformed
from ..props.attach import KINDS
from ..scene import meshes, shape_keys
from ..scene.points import objects as points
from ..scene.seen import look
from . import linked_keys, problems, states, sync_handlers, wraps

NAMES_OF_KINDS = [kind[0] for kind in KINDS]


def attach(
    host: bpy.types.Object, objects: Iterable[bpy.types.Object], kind: str = "", *, may_wait: bool = False
) -> None:
    """Attaches meshes and curves to a mesh, which they follow however it is posed: clothes, hair, eyes.

    Each gets a shape key of the same name and value for each one that the add-on makes on the host. It is bound at
    rest, where it stands now relative to the host; call it again after either was moved. If the host is posed, the
    objects go to the pose at once.

    Args:
        host: the mesh that they follow.
        kind: "bend" or "rigid", where each loose piece keeps its shape; "": rigid if all pieces are small and compact,
            see looks_rigid(), and for an object that is attached already, as it is.
        may_wait: they are bound in the background, if there is a window.

    Raises:
        ValueError: an object cannot be attached; then nothing has changed. RuntimeError: one cannot be bound.
    """
    meshes.check_mesh(host)
    meshes.check_local(host)
    if kind not in {"", *NAMES_OF_KINDS}:
        raise ValueError(f"kind = {kind!r}, must be 'bend' or 'rigid', or '' for the one that fits")
    chosen = list(dict.fromkeys(objects))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for obj in chosen:
        problems.check_new(host, obj, depsgraph)
        look.look(obj, depsgraph)  # the list tells what it says
    places = [wraps.place_now(host, obj, depsgraph) for obj in chosen]
    kinds = [kind] * len(chosen) if kind else _looks(host, chosen, places)
    for each in zip(chosen, places, kinds, strict=True):
        _add(host, *each, is_set=bool(kind))
    with wraps.reading_once():
        for attachment in host.arap.attachments:
            if attachment.object in chosen:
                sync_handlers.sync_changed(host, attachment, may_wait=may_wait and not bpy.app.background)
    error = next(filter(None, (states.of(obj.session_uid).error for obj in chosen)), "")
    if error:
        raise RuntimeError(error)


def detach(host: bpy.types.Object, obj: bpy.types.Object) -> None:
    """Detaches an object from its host. The shape keys that were made for that are removed.

    Raises:
        ValueError: it is not attached to the host, or is in Edit Mode.
    """
    attachment = problems.entry_of(host, obj)
    if attachment is None:
        raise ValueError(f"'{obj.name}' is not attached to '{host.name}'")
    detach_at(host, list(host.arap.attachments).index(attachment))


def detach_at(host: bpy.types.Object, index: int) -> None:
    """As detach(), by the place in the list of the host. The object may be gone."""
    meshes.check_local(host)
    attachments = host.arap.attachments
    if not 0 <= index < len(attachments):
        raise ValueError(f"'{host.name}' has no attachment {index}: it has {len(attachments)}")
    obj = attachments[index].object
    if obj is not None and obj.arap.attached_to.host == host and obj.library is None:
        _release(obj)
    attachments.remove(index)
    host.arap.active_attachment_index = max(0, min(host.arap.active_attachment_index, len(attachments) - 1))


def _looks(host: bpy.types.Object, objects: list[bpy.types.Object], places: list[Floats]) -> list[str]:
    """The kind of each that fits."""
    stretch = meshes.read_stretch(host, bpy.context.evaluated_depsgraph_get())
    mesh = meshes.read_mesh(host)
    size = surface_diagonal(mesh.rest_positions @ stretch.T, mesh.corner_vertices)
    kinds = []
    for attached, place in zip(objects, places, strict=True):
        is_rigid = False
        if attached.type == "MESH":  # the points of a curve do not tell how thick it is
            seen = transformed(place, meshes.read_rest(attached).astype(np.float64)) @ stretch.T
            is_rigid = looks_rigid(seen, *meshes.read_faces(attached.data), size)
        kinds.append("rigid" if is_rigid else "bend")
    return kinds


def _add(host: bpy.types.Object, attached: bpy.types.Object, place: Floats, kind: str, *, is_set: bool) -> None:
    """``is_set``: the kind counts also for one that is in the list already."""
    attachment = problems.entry_of(host, attached)
    link = attached.arap.attached_to
    if link.host not in {None, host}:
        _release(attached)  # from a mesh that is gone, or of which the host is a copy
    link.host = None  # until all is set: nothing is bound before
    if attachment is None:
        attachment = host.arap.attachments.add()
        attachment.object = attached
        is_set = True
    if is_set:
        attachment.kind = kind
    attachment.is_enabled = True
    attachment.set_place(Matrix(place))
    host.arap.active_attachment_index = list(host.arap.attachments).index(attachment)
    if attached.data.shape_keys is None:
        # Now, as a part of the step of undo that this is. Made later, it could be missing after an undo.
        shape_keys.ensure_reference(attached)
        link.has_made_reference = True
    link.host = host


def _release(attached: bpy.types.Object) -> None:
    """Takes back what was made on the object."""
    if points.has_points(attached):
        if attached.data.is_editmode:
            raise ValueError(f"'{attached.name}' is in Edit Mode: go back to Object Mode first")
        linked_keys.keep_only(attached, ())
        if attached.arap.attached_to.has_made_reference:
            shape_keys.remove_lone_reference(attached)
    attached.arap.attached_to.has_made_reference = False
    attached.arap.attached_to.host = None
    sync_handlers.forget(attached.session_uid)
