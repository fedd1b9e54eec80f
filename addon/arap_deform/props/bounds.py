# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings within their bounds. Blender minds them for what is typed and set, but not for what a file holds."""

from __future__ import annotations

import math
from typing import Any

import bpy


def bounded(group: bpy.types.PropertyGroup, name: str) -> Any:
    """A number or an enum of a property group: the nearest bound if it is outside, the default if it is none at all."""
    value = getattr(group, name)
    prop: Any = group.bl_rna.properties[name]
    if prop.type == "ENUM":
        return value or prop.default
    return prop.default if math.isnan(value) else min(max(value, prop.hard_min), prop.hard_max)
