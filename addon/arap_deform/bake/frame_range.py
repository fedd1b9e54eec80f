# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames that the dialogs of a bake and of an export propose."""

from __future__ import annotations

import math

import bpy

from ..scene import fcurves, handle_motion
from ..scene.movers import chain


def proposed_range(obj: bpy.types.Object, scene: bpy.types.Scene) -> tuple[int, int]:
    """From the first to the last key of what moves the handles; the scene's range if that does not say when it ends."""
    movers = chain.transform_sources(obj, handle_motion.enabled_controls(obj))
    spans = [span for mover in movers for data in _data_of(mover) for span in fcurves.spans_of(data)]
    first, last = min((span[0] for span in spans), default=0.0), max((span[1] for span in spans), default=0.0)
    if first == last or math.isinf(last):
        return scene.frame_start, scene.frame_end
    time_scale = fcurves.time_scale(scene)
    # Rounded: 1 / (1 / 3) may be a little more than 3.
    return math.floor(round(first / time_scale, 6)), math.ceil(round(last / time_scale, 6))


def _data_of(mover: bpy.types.Object) -> list[bpy.types.ID]:
    """What may have an animation."""
    return [data for data in (mover, mover.data, getattr(mover.data, "shape_keys", None)) if data]
