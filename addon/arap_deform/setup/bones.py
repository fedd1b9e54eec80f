# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones of an armature that move what they pass through inside the mesh, without vertex groups."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import bpy

from ..scene import handle_motion, meshes
from .handle_changes import making, take_over
from .handles import all_or_none, new_handle

if TYPE_CHECKING:
    from ..props.handles import ArapHandle


def add_bones(obj: bpy.types.Object, armature: bpy.types.Object, bones: Sequence[str] = ()) -> list[ArapHandle]:
    """Makes a handle without a vertex group for each bone, and the model of the mesh solid: it needs an inside.

    The mesh at rest has the armature in its rest position, where that stands now. Bones outside of the mesh move
    nothing. For bones that are handles without a group already, the rest position is read again, as after a change of
    the armature or of its place.

    Args:
        armature: an object of that type.
        bones: names; none: those that deform.

    Returns:
        The handles of the bones.
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
            taken = {h.bone for h in obj.arap.handles if h.target == armature and h.is_bone_alone}
            for name in wanted:
                if name not in taken:
                    with making():
                        handle = new_handle(obj, "", name)
                        handle.target = armature
                        handle.bone = name
            handles = [h for h in obj.arap.handles if h.target == armature and h.is_bone_alone and h.bone in wanted]
            take_over(obj, *handles)
    except BaseException:
        obj.arap.model = former
        raise
    return handles
