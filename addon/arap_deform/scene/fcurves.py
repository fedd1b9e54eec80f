# SPDX-License-Identifier: GPL-3.0-or-later
"""F-curves of data: in an action, in its slot (from Blender 4.4 on), in strips of the NLA."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import bpy


def fcurves_of(data: bpy.types.ID) -> Any:
    """The collection of F-curves that animate ``data``, or None: the action's, from 4.4 on the slot's."""
    animation = data.animation_data
    return _fcurves_in(animation.action, getattr(animation, "action_slot", None)) if animation else None


def all_fcurves_of(data: bpy.types.ID) -> Iterator[bpy.types.FCurve]:
    """The F-curves that animate ``data``, also in its NLA strips."""
    for fcurves in _all_fcurve_lists(data):
        yield from fcurves


def _all_fcurve_lists(data: bpy.types.ID) -> Iterator[Any]:
    """As fcurves_of(), and the same for each NLA strip."""
    animation = data.animation_data
    if animation is not None:
        places = [animation, *(strip for track in animation.nla_tracks for strip in track.strips)]
        lists = (_fcurves_in(place.action, getattr(place, "action_slot", None)) for place in places)
        yield from (fcurves for fcurves in lists if fcurves is not None)


def _fcurves_in(action: bpy.types.Action | None, slot: Any) -> Any:
    if action is None:
        return None
    if not hasattr(action, "layers"):
        return action.fcurves
    for layer in action.layers if slot else ():
        for strip in layer.strips:
            channelbag = strip.channelbag(slot)
            if channelbag is not None:
                return channelbag.fcurves
    return None


def spans_of(data: bpy.types.ID) -> Iterator[tuple[float, float]]:
    """First and last frame of each F-curve and each NLA strip that animates ``data``.

    Infinite ones of a driver, and of an F-curve with modifiers such as Cycles: their keys do not say when they end.
    """
    animation = data.animation_data
    if animation is None:
        return
    for fcurve in fcurves_of(data) or ():
        yield (-math.inf, math.inf) if fcurve.modifiers else tuple(fcurve.range())
    for track in animation.nla_tracks:
        yield from ((s.frame_start, s.frame_end) for s in track.strips if not (track.mute or s.mute))
    if animation.drivers:
        yield -math.inf, math.inf


def has_fcurve(data: bpy.types.ID, data_path: str) -> bool:
    """Whether an F-curve sets ``data_path``, of the action or of an NLA strip."""
    return any(fcurves.find(data_path) is not None for fcurves in _all_fcurve_lists(data))


def is_action_shared(data: bpy.types.ID) -> bool:
    """Whether the action of ``data`` animates other data too, from 4.4 on whether its slot does."""
    animation = data.animation_data
    if hasattr(animation, "action_slot"):
        users = animation.action_slot.users() if animation.action_slot else ()
    else:
        users = bpy.data.user_map(subset=[animation.action])[animation.action]
    return any(user != data for user in users)


def is_animated(data: bpy.types.ID, data_path: str) -> bool:
    """Whether an F-curve or a driver sets ``data_path``."""
    return has_fcurve(data, data_path) or bool(data.animation_data and data.animation_data.drivers.find(data_path))


def remove_animation(data: bpy.types.ID, data_path: str) -> None:
    """Removes driver and F-curves of ``data_path``. In an NLA strip only if nothing else uses the strip's action."""
    data.driver_remove(data_path)
    for fcurves in _all_fcurve_lists(data):
        fcurve = fcurves.find(data_path)
        action = fcurve.id_data if fcurve is not None else None
        is_strips = action is not None and action != data.animation_data.action
        if action is None or (is_strips and (action.library or action.users - action.use_fake_user > 1)):
            continue
        fcurves.remove(fcurve)


def insert_linear_keyframes(
    data: bpy.types.ID, item: Any, data_path: str, keyframes: Sequence[tuple[float, float]]
) -> None:
    """Keyframes ``item.value`` at (frame, value) pairs, linear in between and constant outside.

    Args:
        data: the data-block of ``item``, with path ``data_path``.
    """
    for frame, value in keyframes:
        item.value = value
        item.keyframe_insert("value", frame=frame)
    fcurve = fcurves_of(data).find(data_path)
    fcurve.extrapolation = "CONSTANT"
    for point in fcurve.keyframe_points:
        point.interpolation = "LINEAR"
    fcurve.update()
