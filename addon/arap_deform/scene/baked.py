# SPDX-License-Identifier: GPL-3.0-or-later
"""What shows a baked animation in place of the pose: the keys of the last bake, or a mesh cache. And the way back."""

from __future__ import annotations

from collections.abc import Iterator

import bpy

from . import pose_key, shape_keys


def is_shown(obj: bpy.types.Object) -> bool:
    """Whether a bake shows in place of the pose. Quick, as it is asked at each redraw: the first key stands for all.

    After a bake a muted pose counts alone: the artist may have removed or renamed the keys of the bake.
    """
    for modifier in obj.modifiers:
        if shape_keys.hides_keys(modifier):
            return True
    if not obj.arap.bake_prefix:
        return False
    pose = pose_key.find(obj)
    if pose is not None and pose.mute:
        return True
    name = next(_names(obj), None)
    return name is not None and not obj.data.shape_keys.key_blocks[name].mute


def edit_again(obj: bpy.types.Object, *, is_removing: bool = False) -> None:
    """Shows the pose again: mutes or removes the keys of the bake, switches a mesh cache off, unmutes the pose's key.

    The next bake replaces muted keys.

    Raises:
        ValueError: the mesh must not be written.
    """
    shape_keys.check_writable(obj)
    for modifier in obj.modifiers:
        if shape_keys.hides_keys(modifier):
            modifier.show_viewport = modifier.show_render = False
    if is_removing:
        _remove_all(obj)
    _mute(obj)
    pose = pose_key.find(obj)
    if pose is not None:
        pose.mute = False
    obj.arap.follow_error = ""
    obj.data.update_tag()


def show(obj: bpy.types.Object, prefix: str) -> None:
    """Notes that the keys of this bake show, and mutes those of one with another prefix: they would add to these."""
    settings = obj.arap
    former = settings.bake_prefix
    if former != prefix:
        _mute(obj)
        if former and former not in settings.former_bakes:
            settings.former_bakes.add().name = former
        settings.bake_prefix = prefix
    shape_keys.notify_keys_changed(obj)


def _mute(obj: bpy.types.Object) -> None:
    """Mutes the keys of the last bake."""
    for name in list(_names(obj)):
        obj.data.shape_keys.key_blocks[name].mute = True


def _remove_all(obj: bpy.types.Object) -> None:
    """Removes the keys of the last bake and of former ones."""
    shape_keys.remove(obj, *names_of_all(obj))
    obj.arap.former_bakes.clear()


def names_of_all(obj: bpy.types.Object) -> list[str]:
    """Names of the keys of the last bake and of former ones."""
    former = [name for bake in obj.arap.former_bakes if bake.name for name in shape_keys.frame_keys(obj, bake.name)]
    return [*_names(obj), *former]


def _names(obj: bpy.types.Object) -> Iterator[str]:
    """Names of the keys of the last bake."""
    return shape_keys.frame_keys(obj, obj.arap.bake_prefix) if obj.arap.bake_prefix else iter(())
