# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames that the dialogs of a bake and of an export propose."""

from __future__ import annotations

import math

import bpy

from ..scene import fcurves


def proposed_range(obj: bpy.types.Object, scene: bpy.types.Scene) -> tuple[int, int]:
    """From the first to the last key of what moves the handles; the scene's range if that does not say when it ends."""
    spans = [span for mover in _movers(obj) for data in _data_of(mover) for span in fcurves.spans_of(data)]
    first, last = min((span[0] for span in spans), default=0.0), max((span[1] for span in spans), default=0.0)
    if first == last or math.isinf(last):
        return scene.frame_start, scene.frame_end
    return math.floor(first), math.ceil(last)


def _data_of(mover: bpy.types.Object) -> list[bpy.types.ID]:
    """What may have an animation; of a cage also its shape keys."""
    return [data for data in (mover, mover.data, getattr(mover.data, "shape_keys", None)) if data]


def _movers(obj: bpy.types.Object) -> set[bpy.types.Object]:
    """The objects of the handles, their parents, and what their modifiers, constraints and bones' constraints name."""
    found: set[bpy.types.Object] = set()
    todo = [handle.target for handle in obj.arap.handles if handle.is_enabled]
    while todo:
        item = todo.pop()
        if item is None or item == obj or item in found:
            continue
        found.add(item)
        owners = (item, *(item.pose.bones if item.pose else ()))
        todo += [item.parent, *(getattr(c, "target", None) for owner in owners for c in owner.constraints)]
        todo += [getattr(modifier, "object", None) for modifier in item.modifiers]
    return found
