# SPDX-License-Identifier: GPL-3.0-or-later
"""F-curves of data: in an action, in its slot (from Blender 4.4 on), in strips of the NLA."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import bpy
import numpy as np

# Of a keyframe, with the numbers in each: types of handles before the handles, which depend on them.
POINT_FIELDS = (
    ("co", 2, np.float32),
    *((name, 1, np.int32) for name in ("interpolation", "easing", "handle_left_type", "handle_right_type", "type")),
    *((name, 1, np.float32) for name in ("back", "amplitude", "period")),
    ("handle_left", 2, np.float32),
    ("handle_right", 2, np.float32),
)


def fcurves_of(data: bpy.types.ID) -> Any:
    """The collection of F-curves that animate ``data``, or None: the action's, from 4.4 on the slot's."""
    animation = data.animation_data
    return _fcurves_in(animation.action, getattr(animation, "action_slot", None)) if animation else None


def all_fcurves_of(data: bpy.types.ID) -> Iterator[bpy.types.FCurve]:
    """The F-curves that animate ``data``, also in its NLA strips."""
    for fcurves in _all_fcurve_lists(data):
        yield from fcurves


def _all_fcurve_lists(data: bpy.types.ID) -> Iterator[Any]:
    """As fcurves_of(), and the same for each NLA strip; what is in several strips comes once."""
    animation = data.animation_data
    if animation is None:
        return
    places = [animation, *(strip for track in animation.nla_tracks for strip in track.strips)]
    seen: list[tuple[bpy.types.Action, Any]] = []
    for place in places:
        where = place.action, getattr(place, "action_slot", None)
        fcurves = _fcurves_in(*where)
        if fcurves is not None and where not in seen:
            seen.append(where)
            yield fcurves


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
    return _has_other_users(data, animation.action, getattr(animation, "action_slot", None))


def _has_other_users(data: bpy.types.ID, action: bpy.types.Action, slot: Any) -> bool:
    """Whether an action, or a slot of it, animates other data than ``data``."""
    if not hasattr(action, "slots"):
        return any(user != data for user in bpy.data.user_map(subset=[action])[action])
    return slot is not None and any(user != data for user in slot.users())


def is_animated(data: bpy.types.ID, data_path: str) -> bool:
    """Whether an F-curve or a driver sets ``data_path``."""
    return has_fcurve(data, data_path) or bool(data.animation_data and data.animation_data.drivers.find(data_path))


def remove_animation(data: bpy.types.ID, data_path: str) -> None:
    """Removes driver and F-curves of ``data_path``. In an NLA strip only if nothing else uses the strip's action."""
    data.driver_remove(data_path)
    for fcurves in _all_fcurve_lists(data):
        fcurve = fcurves.find(data_path)
        if fcurve is not None and _may_remove(data, fcurve.id_data):
            fcurves.remove(fcurve)


def _may_remove(data: bpy.types.ID, action: bpy.types.Action) -> bool:
    animation = data.animation_data
    if action == animation.action:
        return True
    strips = [strip for track in animation.nla_tracks for strip in track.strips if strip.action == action]
    is_shared = any(_has_other_users(data, action, getattr(strip, "action_slot", None)) for strip in strips)
    return action.library is None and not is_shared


def time_scale(scene: bpy.types.Scene) -> float:
    """What Time Stretching makes of a frame: in frame f Blender evaluates F-curves and caches at f times this."""
    return float(scene.render.frame_map_old / scene.render.frame_map_new)


def insert_linear_keyframes(
    data: bpy.types.ID, item: Any, data_path: str, keyframes: Sequence[tuple[float, float]]
) -> None:
    """Keyframes ``item.value`` at (time, value) pairs alone, linear in between and constant outside.

    Args:
        data: the data-block of ``item``, with path ``data_path``.
    """
    fcurve = _new_fcurve(data, item, data_path, len(keyframes))
    fcurve.keyframe_points.foreach_set("co", np.asarray(keyframes, dtype=np.float32).ravel())
    for point in fcurve.keyframe_points:
        point.interpolation = "LINEAR"
    fcurve.extrapolation = "CONSTANT"
    fcurve.update()


def copy_keyframes(source: bpy.types.FCurve, data: bpy.types.ID, item: Any, data_path: str) -> None:
    """Gives ``item.value`` the keyframes of another F-curve, and its modifiers. Does nothing if it has them."""
    fcurves = fcurves_of(data)
    former = fcurves.find(data_path) if fcurves is not None else None
    if former is not None and _shape_of(former) == _shape_of(source):
        return
    fcurve = _new_fcurve(data, item, data_path, len(source.keyframe_points))
    for field, n, kind in POINT_FIELDS:
        values = np.empty(len(source.keyframe_points) * n, dtype=kind)
        source.keyframe_points.foreach_get(field, values)
        fcurve.keyframe_points.foreach_set(field, values)
    fcurve.extrapolation, fcurve.auto_smoothing = source.extrapolation, source.auto_smoothing
    for modifier in source.modifiers:
        copy = fcurve.modifiers.new(modifier.type)
        for name, value in _settings_of(modifier).items():
            setattr(copy, name, value)
    fcurve.update()


def _new_fcurve(data: bpy.types.ID, item: Any, data_path: str, n: int) -> bpy.types.FCurve:
    """An F-curve of ``item.value`` with ``n`` keyframes, in place of a former one."""
    fcurves = fcurves_of(data)
    former = fcurves.find(data_path) if fcurves is not None else None
    if former is not None:
        fcurves.remove(former)
    item.keyframe_insert("value", frame=0.0)  # makes what is missing: action, layer, slot
    fcurve = fcurves_of(data).find(data_path)
    fcurve.keyframe_points.add(n - 1)
    return fcurve


def _shape_of(fcurve: bpy.types.FCurve) -> list[Any]:
    """What copy_keyframes() copies."""
    ways = fcurve.extrapolation, fcurve.auto_smoothing
    shape: list[Any] = [*ways, *(_settings_of(modifier) for modifier in fcurve.modifiers)]
    for field, n, kind in POINT_FIELDS:
        values = np.empty(len(fcurve.keyframe_points) * n, dtype=kind)
        fcurve.keyframe_points.foreach_get(field, values)
        shape.append(values.tobytes())
    return shape


def _settings_of(modifier: bpy.types.FModifier) -> dict[str, Any]:
    settings = {}
    for name, field in modifier.bl_rna.properties.items():
        if not field.is_readonly and name != "active":
            value = getattr(modifier, name)
            settings[name] = tuple(value) if getattr(field, "is_array", False) else value
    return settings
