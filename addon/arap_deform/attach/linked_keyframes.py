# SPDX-License-Identifier: GPL-3.0-or-later
"""The keyframes of linked keys: those of their hosts' keys, where exporters find them.

In Blender a driver moves a linked key, and its keyframes do nothing. But glTF takes animation only from an action of
the mesh itself, and makes one animation of each action. So linked keys have their keyframes in a slot of the host's
action. Blender before 4.4 has no slots, but there glTF makes one animation of NLA tracks with one name: muted ones hold
the actions.
"""

from __future__ import annotations

import bpy

from ..scene import fcurves, shape_keys


def copy(
    host: bpy.types.Object, key: bpy.types.ShapeKey, attached: bpy.types.Object, linked: bpy.types.ShapeKey
) -> None:
    """Copies the keyframes of the host's key to its linked key, or removes them if that has none."""
    of_host, path = host.data.shape_keys, shape_keys.value_path(key)
    in_action = fcurves.fcurves_of(of_host)
    source = in_action.find(path) if in_action is not None else None
    if source is not None and len(source.keyframe_points):
        if _join(of_host, attached):
            fcurves.copy_keyframes(source, attached.data.shape_keys, linked, shape_keys.value_path(linked))
    elif not fcurves.has_fcurve(of_host, path):  # in a strip it goes on as it is
        _take_away(attached, linked)


def leave(attached: bpy.types.Object) -> None:
    """Removes the place for the keyframes of linked keys, when the last one is gone."""
    keys = attached.data.shape_keys
    animation = keys.animation_data if keys is not None else None
    if animation is None or animation.action is None or fcurves.fcurves_of(keys):
        return
    action, slot = animation.action, getattr(animation, "action_slot", None)
    animation.action = None
    if slot is not None and action.library is None and not slot.users():
        action.slots.remove(slot)
    for track in [track for track in animation.nla_tracks if track.mute and slot is None]:
        if all(strip.action == action for strip in track.strips):
            animation.nla_tracks.remove(track)


def _join(of_host: bpy.types.Key, attached: bpy.types.Object) -> bool:
    """Makes the place for keyframes of linked keys; False if there can be none, and the driver must do."""
    keys = attached.data.shape_keys
    animation = keys.animation_data or keys.animation_data_create()
    if hasattr(animation, "action_slot"):
        _take_slot(of_host.animation_data.action, attached)
    try:
        shape_keys.check_animatable(attached)
    except ValueError:  # an action that belongs to others, too
        return False
    if not hasattr(animation, "action_slot"):
        if animation.action is None:
            animation.action = bpy.data.actions.new(f"{attached.name}Action")
        name = _track_name(of_host)
        for data in (of_host, keys):
            _put_into_track(data, name)
    return True


def _take_slot(action: bpy.types.Action, attached: bpy.types.Object) -> None:
    """Animates the keys by a slot of their own in the action, unless the artist animates them elsewhere."""
    keys = attached.data.shape_keys
    animation = keys.animation_data
    if animation.action != action:
        linked_keys = (shape_keys.find(attached, linked.key) for linked in attached.arap.attached_to.linked_keys)
        paths = {shape_keys.value_path(linked) for linked in linked_keys if linked is not None}
        if action.library is not None or any(f.data_path not in paths for f in fcurves.fcurves_of(keys) or ()):
            return
        former = animation.action
        animation.action = action
        if former is not None and not former.users:
            bpy.data.actions.remove(former)
    if animation.action_slot is None or fcurves.is_action_shared(keys):
        animation.action_slot = action.slots.new("KEY", attached.name)


def _track_name(data: bpy.types.Key) -> str:
    """The name of the track that its action is in: that of the other host's, for a host that is attached itself."""
    animation = data.animation_data
    tracks = (track for track in animation.nla_tracks if track.mute)
    names = [track.name for track in tracks if any(strip.action == animation.action for strip in track.strips)]
    return str(names[0] if names else animation.action.name)


def _put_into_track(data: bpy.types.Key, name: str) -> None:
    """Puts the action into a muted track of that name, where it does nothing."""
    animation = data.animation_data
    tracks = [track for track in animation.nla_tracks if track.name == name and track.mute]
    if not any(strip.action == animation.action for track in tracks for strip in track.strips):
        track = animation.nla_tracks.new()
        track.name, track.mute = name, True
        track.strips.new(name, 1, animation.action)


def _take_away(attached: bpy.types.Object, linked: bpy.types.ShapeKey) -> None:
    own = fcurves.fcurves_of(attached.data.shape_keys)
    fcurve = own.find(shape_keys.value_path(linked)) if own is not None else None
    if fcurve is not None and fcurve.id_data.library is None:
        own.remove(fcurve)
