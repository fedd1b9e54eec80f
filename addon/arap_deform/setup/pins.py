# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins of an object: making and removing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..scene.groups import VertexIndices
from .lists import GroupList

if TYPE_CHECKING:
    from ..props.handles import ArapPin

PINS = GroupList("pin", "pins", "active_pin_index")


def add_pin(obj: bpy.types.Object, vertices: VertexIndices, name: str = "Pin") -> ArapPin:
    """Makes a vertex group of ``vertices`` (weight 1) and pins it at rest."""
    pin: ArapPin = PINS.add_vertices(obj, vertices, name)
    return pin


def add_pin_group(obj: bpy.types.Object, vertex_group: str) -> ArapPin:
    """Pins an existing vertex group; where it is pinned already, returns that pin, enabled."""
    pin: ArapPin = PINS.add_group(obj, vertex_group)
    return pin


def remove_pin(obj: bpy.types.Object, index: int) -> None:
    """Removes a pin, and its vertex group where the pin made it and nothing else uses it."""
    PINS.remove(obj, index)
