# SPDX-License-Identifier: GPL-3.0-or-later
"""What a change of a handle by the artist brings along: the mesh must not jump, and what was made has its name."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import bpy
import numpy as np
from mathutils import Matrix

from ..core import naming
from ..core.transforms import inverted
from ..props import hooks
from ..scene import groups, handle_motion, pose_key, staying
from ..scene.held import HeldMesh, fit
from ..scene.inputs import has_group

if TYPE_CHECKING:
    from ..props.handles import ArapHandle
    from ..scene.held import Entry

_is_making = False


@contextmanager
def making() -> Iterator[None]:
    """While a function fills in a handle: its steps are not choices of the artist."""
    global _is_making  # noqa: PLW0603 - Blender's update callbacks take no other message
    _is_making = True
    try:
        yield
    finally:
        _is_making = False


def take_over(obj: bpy.types.Object, *entries: Entry) -> None:
    """Lets pins and handles hold the pose shown now, wherever the objects of handles are: the mesh must not jump.

    But bones without a vertex group: the mesh at rest has their armature at rest.

    Called after a change of a handle's target, bone or group. Passes over entries of which one of these is missing.
    """
    if obj.type != "MESH":
        return
    depsgraph = staying.evaluated_within(obj)
    use_nodes = False if obj.mode == "EDIT" else None  # nodes would read the mesh that is being edited
    whole = [entry for entry in entries if not _lack_of(obj, entry, depsgraph)]
    _set_rests(obj, [entry for entry in whole if hasattr(entry, "target")], depsgraph, use_nodes)
    staying.stay(obj, depsgraph, *whole, use_nodes=use_nodes)


def _lack_of(obj: bpy.types.Object, entry: Entry, depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether its group or its object is missing."""
    if hasattr(entry, "target") and handle_motion.target_problem(obj, entry.target, entry.bone, depsgraph):
        return True
    return not has_group(obj, entry)


def _set_rests(
    obj: bpy.types.Object, handles: Sequence[ArapHandle], depsgraph: bpy.types.Depsgraph, use_nodes: bool | None
) -> None:
    """Sets the rest matrices of handles so that the places of their objects now give the pose shown now."""
    if not handles:
        return
    inverse = inverted(handle_motion.object_matrix(obj, depsgraph))
    motions = np.tile(np.eye(4), (len(handles), 1, 1))
    if pose_key.shown(obj) is not None:
        held = HeldMesh(obj, depsgraph, use_nodes=use_nodes)
        for i, (handle, spec) in enumerate(zip(handles, held.specs_of(handles), strict=True)):
            if len(spec.vertices):
                motions[i] = fit(held, spec, handle).motion
    for handle, motion in zip(handles, motions, strict=True):
        if handle.is_bone_alone:
            matrix = handle_motion.bone_rest_matrix(handle.target, handle.bone, depsgraph)
        else:
            matrix = handle_motion.target_matrix(handle.target, handle.bone, depsgraph)
        handle.rest = Matrix(inverted(motion) @ inverse @ matrix)


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


CALLBACKS = ((hooks.handle_changed, _on_changed), (hooks.handle_renamed, _on_renamed))
