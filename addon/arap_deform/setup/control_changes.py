# SPDX-License-Identifier: GPL-3.0-or-later
"""Called when the artist changes the object, bone, group or name of a control.

The control is rebased so that the mesh does not jump, and its empty and vertex group take its name.
"""

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
from ..scene import groups, handle_motion, pose_key, preserve_shape
from ..scene.constraint_preview import ConstraintPreview, place_handle
from ..scene.inputs import has_group

if TYPE_CHECKING:
    from ..props.controls import ArapControl

_are_updates_suppressed = False


@contextmanager
def suppress_updates() -> Iterator[None]:
    """While a function fills in a control: its steps are not choices of the artist."""
    global _are_updates_suppressed  # noqa: PLW0603 - Blender's update callbacks take no other message
    former, _are_updates_suppressed = _are_updates_suppressed, True
    try:
        yield
    finally:
        _are_updates_suppressed = former


def rebase(obj: bpy.types.Object, *controls: ArapControl) -> None:
    """Lets pins and handles hold the pose shown now, wherever the objects of handles are: the mesh must not jump.

    But bones without a vertex group: the mesh at rest has their armature at rest.

    Called after a change of a kind, object, bone or group. Passes over controls of which one of these is missing.
    """
    if obj.type != "MESH":
        return
    depsgraph = preserve_shape.evaluated_within(obj)
    use_nodes = False if obj.mode == "EDIT" else None  # nodes would read the mesh that is being edited
    whole = [control for control in controls if not _lack_of(obj, control, depsgraph)]
    _set_rests(obj, [control for control in whole if not control.is_pin], depsgraph, use_nodes)
    preserve_shape.keep_shown_shape(obj, depsgraph, *whole, use_nodes=use_nodes)


def _lack_of(obj: bpy.types.Object, control: ArapControl, depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether its group or its object is missing."""
    needs_bone = control.kind == "bone"
    if not control.is_pin and handle_motion.target_problem(
        obj, control.target, control.bone, depsgraph, needs_bone=needs_bone
    ):
        return True
    return not has_group(obj, control)


def _set_rests(
    obj: bpy.types.Object, handles: Sequence[ArapControl], depsgraph: bpy.types.Depsgraph, use_nodes: bool | None
) -> None:
    """Sets the rest matrices of handles so that the places of their objects now give the pose shown now."""
    if not handles:
        return
    inverse = inverted(handle_motion.object_matrix(obj, depsgraph))
    motions = np.tile(np.eye(4), (len(handles), 1, 1))
    if pose_key.shown(obj) is not None:
        held = ConstraintPreview(obj, depsgraph, use_nodes=use_nodes)
        for i, (handle, spec) in enumerate(zip(handles, held.specs_of(handles), strict=True)):
            if len(spec.vertices):
                motions[i] = place_handle(held, spec, handle).motion
    for handle, motion in zip(handles, motions, strict=True):
        if handle.kind == "bone":
            matrix = handle_motion.bone_rest_matrix(handle.target, handle.bone, depsgraph)
        else:
            matrix = handle_motion.target_matrix(handle.target, handle.bone, depsgraph)
        handle.rest = Matrix(inverted(motion) @ inverse @ matrix)


def _on_changed(obj: bpy.types.Object, control: ArapControl) -> None:
    if _are_updates_suppressed:
        return
    try:
        rebase(obj, control)
    except ValueError:
        control.rest_matrix = (0.0,) * 16  # the rest place is unknown, which control_problem() reports


def _on_renamed(obj: bpy.types.Object, control: ArapControl) -> None:
    """Keeps names unique, and gives the empty and the vertex group that were made for a control its new name."""
    if _are_updates_suppressed:
        return
    others = {other.name for other in obj.arap.controls if other != control}
    name = naming.unique(naming.cut(control.name) or control.kind.capitalize(), others)
    with suppress_updates():
        control.name = name
        if control.has_made_group:
            control.vertex_group = groups.rename(obj, control.vertex_group, name)
            control.has_made_group = True  # last: setting the group clears it
    if control.has_made_target and control.target and not handle_motion.other_owner(obj, control):
        control.target.name = name


CALLBACKS = ((hooks.control_changed, _on_changed), (hooks.control_renamed, _on_renamed))
