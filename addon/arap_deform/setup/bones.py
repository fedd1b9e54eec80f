# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones of an armature that move what they pass through inside the mesh, without vertex groups."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import bpy

from ..scene import handle_motion, meshes
from .handles import all_or_none, making, new_handle, take_over

if TYPE_CHECKING:
    from ..props.handles import ArapHandle


def add_bones(obj: bpy.types.Object, armature: bpy.types.Object, bones: Sequence[str] = ()) -> list[ArapHandle]:
    """Makes a handle without a vertex group for each bone, and the model of the mesh solid: it needs an inside.

    The mesh at rest has the armature in its rest position, where that stands now. Bones that are handles without a
    group already are passed over; those outside of the mesh move nothing.

    Args:
        armature: an object of that type.
        bones: names; none: those that deform.
    """
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    if armature is None or armature.type != "ARMATURE":
        raise ValueError(f"'{obj.name}' cannot take the bones: choose an armature")
    wanted = list(bones) or [bone.name for bone in armature.data.bones if bone.use_deform]
    taken = {handle.bone for handle in obj.arap.handles if handle.target == armature and handle.is_bone_alone}
    wanted = [name for name in wanted if name not in taken]
    if not wanted:
        raise ValueError(f"'{armature.name}' has no other bones that deform: its bones move '{obj.name}' already")
    depsgraph = bpy.context.evaluated_depsgraph_get()
    for name in wanted:
        reason = handle_motion.target_problem(obj, armature, name, depsgraph)
        if reason:
            raise ValueError(f"'{obj.name}' cannot take the bones: {reason}")
    twice = [m.name for m in obj.modifiers if m.type == "ARMATURE" and m.object == armature and m.show_viewport]
    if twice:
        raise ValueError(
            f"Modifier '{twice[0]}' of '{obj.name}' moves the mesh with the same armature: remove it, or switch it off"
        )
    former = obj.arap.model
    try:
        with all_or_none(obj) as first:
            obj.arap.model = "solid"
            for name in wanted:
                with making():
                    handle = new_handle(obj, "", name)
                    handle.target = armature
                    handle.bone = name
            take_over(obj, *obj.arap.handles[first:])
    except BaseException:
        obj.arap.model = former
        raise
    return list(obj.arap.handles[first:])
