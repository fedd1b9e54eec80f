# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings within their bounds. Blender minds them for what is typed and set, but not for what a file holds."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import bpy


def bounded(group: bpy.types.PropertyGroup, name: str) -> Any:
    """A number or an enum of a property group: the nearest bound if it is outside, the default if it is none at all."""
    return all_bounded(group, (name,))[name]


def all_bounded(group: bpy.types.PropertyGroup, names: Iterable[str]) -> dict[str, Any]:
    """As bounded(), of several, by name: each frame reads them."""
    values: dict[str, Any] = {}
    for name in names:
        value, prop = getattr(group, name), group.bl_rna.properties[name]
        if prop.type == "ENUM":
            values[name] = value or prop.default
        else:
            values[name] = prop.default if math.isnan(value) else min(max(value, prop.hard_min), prop.hard_max)
    return values
