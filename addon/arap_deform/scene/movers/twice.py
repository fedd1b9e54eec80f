# SPDX-License-Identifier: GPL-3.0-or-later
"""Why an object or bone would move the mesh twice: as a handle, and as what it is skinned or hooked to."""

from __future__ import annotations

from collections.abc import Container

import bpy

from .. import meshes


def why_twice(obj: bpy.types.Object, target: bpy.types.Object, bone: str) -> str:
    """What moves the mesh with the handle's object or bone already, and what to do; '' if nothing does."""
    what = f"bone '{bone}'" if bone else f"'{target.name}'"
    for modifier in obj.modifiers:
        if meshes.is_switched_on(modifier) and _is_moved(obj, modifier, target, bone):
            other = "" if modifier.type == "HOOK" else ", or take a bone that does not deform"
            return (
                f"modifier '{modifier.name}' moves the mesh with {what} already; remove it or switch it off, in "
                f"viewports and renders{other}"
            )
    if obj.parent == target and obj.parent_type == "ARMATURE" and _deforms(target, bone):
        return f"the parent (Armature Deform) moves the mesh with {what} already; clear the parent, and keep the place"
    return ""


def _is_moved(obj: bpy.types.Object, modifier: bpy.types.Modifier, target: bpy.types.Object, bone: str) -> bool:
    if modifier.type == "HOOK":
        return bool(modifier.object == target and modifier.subtarget == bone)
    if modifier.type != "ARMATURE" or modifier.object != target:
        return False
    if not bone:
        return not _is_above(target, obj)
    if modifier.use_bone_envelopes:
        return _deforms(target, bone)
    # A mesh without any group of the armature is to get them: its first weights would move it twice.
    groups = [group.name for group in obj.vertex_groups if group.name in target.data.bones]
    return modifier.use_vertex_groups and _deforms(target, bone, groups or None)


def _deforms(armature: bpy.types.Object, bone: str, groups: Container[str] | None = None) -> bool:
    """Whether the bone, or one that hangs on it, is there to deform; without a name, any.

    ``groups``: the names of the bones that have a vertex group, if others move nothing.
    """
    bones = armature.data.bones
    todo = [found for found in [bones.get(bone)] if found is not None] if bone else list(bones)
    for each in todo:  # which grows
        if each.use_deform and (groups is None or each.name in groups):
            return True
        todo += each.children
    return False


def _is_above(target: bpy.types.Object, obj: bpy.types.Object) -> bool:
    """Whether the object is moved along as a whole: in its own space nothing moves."""
    parent = obj.parent
    while parent is not None and parent != target:
        parent = parent.parent
    return parent is not None
