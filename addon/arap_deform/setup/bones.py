# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones of an armature that move what they pass through inside the mesh, without vertex groups."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import bpy

from ..scene import handle_motion, meshes
from .control_changes import rebase, suppress_updates
from .controls import all_or_none, new_control

if TYPE_CHECKING:
    from ..props.controls import ArapControl


def add_bones(obj: bpy.types.Object, armature: bpy.types.Object, bones: Sequence[str] = ()) -> list[str]:
    """Lets each bone move what it passes through, and the model of the mesh solid: it needs an inside.

    The mesh at rest has the armature in its rest position, where that stands now. Bones outside of the mesh move
    nothing. For bones that are in the list already, the rest position is read again, as after a change of
    the armature or of its place.

    Args:
        armature: an object of that type.
        bones: names; none: those that deform.

    Returns:
        The names of the bones in the list.
    """
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    if armature is None or armature.type != "ARMATURE":
        raise ValueError(f"'{obj.name}' cannot take the bones: choose an armature")
    wanted = list(dict.fromkeys(bones)) or [bone.name for bone in armature.data.bones if bone.use_deform]
    if not wanted:
        raise ValueError(f"'{armature.name}' has no bones that deform: select the bones in Pose Mode")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for name in wanted:
        reason = handle_motion.target_problem(obj, armature, name, depsgraph)
        if reason:
            raise ValueError(f"'{obj.name}' cannot take the bones: {reason}")
    former = obj.arap.model
    try:
        with all_or_none(obj):
            obj.arap.model = "solid"
            taken = {control.bone for control in _bones_of(obj, armature)}
            for name in wanted:
                if name not in taken:
                    bone = new_control(obj, "bone", name)
                    with suppress_updates():
                        bone.target = armature
                        bone.bone = name
            found = [control for control in _bones_of(obj, armature) if control.bone in wanted]
            rebase(obj, *found)
    except BaseException:
        obj.arap.model = former
        raise
    return [str(control.name) for control in found]


def _bones_of(obj: bpy.types.Object, armature: bpy.types.Object) -> list[ArapControl]:
    return [control for control in obj.arap.controls if control.kind == "bone" and control.target == armature]
