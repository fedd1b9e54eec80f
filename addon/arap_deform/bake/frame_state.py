# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of animated properties, which a change of frame would lose.

When the frame changes, Blender writes the value of every F-curve to its property. A move of an animated object that has
no keyframe yet is then lost. So code that visits other frames calls capture() before and restore() after.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import bpy

from ..scene import fcurves

Place = tuple[str, str, bool]  # collection of bpy.data, name, whether it is the node tree inside that data-block
Channel = tuple[str, int]  # data path and index
AnimatedValues = dict[Place, dict[Channel, Any]]

# The last part of a data path: a property, or the name of a custom property.
LAST_PART = re.compile(r'(?:(?P<owner>.*)\.)?(?P<name>\w+)|(?P<custom_owner>.*)\["(?P<key>(?:[^"\\]|\\.)*)"\]')


def capture() -> AnimatedValues:
    """Present values of everything in the file that F-curves set; no Blender data."""
    values: AnimatedValues = {}
    for place, data in _animated():
        for fcurve in fcurves.all_fcurves_of(data):
            channel = fcurve.data_path, fcurve.array_index
            value = _value(data, channel)
            if value is not None:
                values.setdefault(place, {})[channel] = value
    return values


def drop(values: AnimatedValues, data: bpy.types.ID, data_paths: set[str]) -> None:
    """Takes these paths of a data-block out, so that restore() leaves them alone."""
    for (_, name, _), channels in values.items():
        if name == data.name:
            for channel in [channel for channel in channels if channel[0] in data_paths]:
                del channels[channel]


def restore(values: AnimatedValues) -> None:
    """Sets what is different now. Call it in the frame of capture(). Data that is gone is passed over."""
    for place, channels in values.items():
        data = _data_at(place)
        if data is None:
            continue
        for channel, value in channels.items():
            now = _value(data, channel)
            if now is not None and now != value:
                with suppress(AttributeError, TypeError, ValueError):  # now read-only: Blender passes it over too
                    _set_value(data, channel, value)


def _animated() -> Iterator[tuple[Place, bpy.types.ID]]:
    """Every local data-block with animation; linked ones cannot be changed."""
    for prop in bpy.data.bl_rna.properties:
        if prop.type != "COLLECTION":
            continue
        for data in getattr(bpy.data, prop.identifier):
            if data.library is not None:
                continue
            for is_tree, item in ((False, data), (True, getattr(data, "node_tree", None))):
                if getattr(item, "animation_data", None) is not None:
                    yield (prop.identifier, data.name, is_tree), item


def _data_at(place: Place) -> bpy.types.ID | None:
    collection, name, is_tree = place
    data = getattr(bpy.data, collection).get((name, None))  # None: the local one, not one of a library
    return getattr(data, "node_tree", None) if is_tree else data


def _value(data: bpy.types.ID, channel: Channel) -> Any:
    path, index = channel
    try:
        value = data.path_resolve(path)
        return value[index] if _is_array(value) else value
    except (ValueError, IndexError):  # a path that leads nowhere: Blender passes it over too
        return None


def _set_value(data: bpy.types.ID, channel: Channel, value: Any) -> None:
    path, index = channel
    array = data.path_resolve(path)
    if _is_array(array):
        array[index] = value
        return
    match = LAST_PART.fullmatch(path)
    if match is None:
        return
    if match["key"] is not None:
        owner = data.path_resolve(match["custom_owner"]) if match["custom_owner"] else data
        owner[bpy.utils.unescape_identifier(match["key"])] = value
    else:
        owner = data.path_resolve(match["owner"]) if match["owner"] else data
        setattr(owner, match["name"], value)


def _is_array(value: Any) -> bool:
    return hasattr(value, "__len__") and not isinstance(value, str)
