# SPDX-License-Identifier: GPL-3.0-or-later
"""The keyframes of twins: those of the keys that they stand for, where exporters find them.

In Blender a driver moves a twin, and its keyframes do nothing. But glTF takes animation only from an action of the mesh
itself, and makes one animation of each action. So twins have their keyframes in a slot of the body's action. Blender
before 4.4 has no slots, but there glTF makes one animation of NLA tracks with one name: muted ones hold the actions.
"""

from __future__ import annotations

import bpy

from ..scene import fcurves, shape_keys


def copy(body: bpy.types.Object, key: bpy.types.ShapeKey, target: bpy.types.Object, twin: bpy.types.ShapeKey) -> None:
    """Gives a twin the keyframes of its key, or takes them away if that has none."""
    of_body, path = body.data.shape_keys, shape_keys.value_path(key)
    in_action = fcurves.fcurves_of(of_body)
    source = in_action.find(path) if in_action is not None else None
    if source is not None and len(source.keyframe_points):
        if _join(of_body, target):
            fcurves.copy_keyframes(source, target.data.shape_keys, twin, shape_keys.value_path(twin))
    elif not fcurves.has_fcurve(of_body, path):  # in a strip it goes on as it is
        _take_away(target, twin)


def leave(target: bpy.types.Object) -> None:
    """The last twin is gone: so is the place for their keyframes."""
    keys = target.data.shape_keys
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


def _join(of_body: bpy.types.Key, target: bpy.types.Object) -> bool:
    """Makes the place for keyframes of twins; False if there can be none, and the driver must do."""
    keys = target.data.shape_keys
    animation = keys.animation_data or keys.animation_data_create()
    if hasattr(animation, "action_slot"):
        _take_slot(of_body.animation_data.action, target)
    try:
        shape_keys.check_animatable(target)
    except ValueError:  # an action that belongs to others, too
        return False
    if not hasattr(animation, "action_slot"):
        if animation.action is None:
            animation.action = bpy.data.actions.new(f"{target.name}Action")
        name = _track_name(of_body)
        for data in (of_body, keys):
            _put_into_track(data, name)
    return True


def _take_slot(action: bpy.types.Action, target: bpy.types.Object) -> None:
    """Animates the keys of ``target`` by a slot of its own in the action, unless the artist animates them elsewhere."""
    keys = target.data.shape_keys
    animation = keys.animation_data
    if animation.action != action:
        twins = (shape_keys.find(target, twin.key) for twin in target.arap.carried.twins)
        paths = {shape_keys.value_path(twin) for twin in twins if twin is not None}
        if action.library is not None or any(f.data_path not in paths for f in fcurves.fcurves_of(keys) or ()):
            return
        former = animation.action
        animation.action = action
        if former is not None and not former.users:
            bpy.data.actions.remove(former)
    if animation.action_slot is None or fcurves.is_action_shared(keys):
        animation.action_slot = action.slots.new("KEY", target.name)


def _track_name(data: bpy.types.Key) -> str:
    """Of the track that its action is in: a body that goes along with another one has the name of that one's."""
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


def _take_away(target: bpy.types.Object, twin: bpy.types.ShapeKey) -> None:
    own = fcurves.fcurves_of(target.data.shape_keys)
    fcurve = own.find(shape_keys.value_path(twin)) if own is not None else None
    if fcurve is not None and fcurve.id_data.library is None:
        own.remove(fcurve)
