# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins of an object: making and removing."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from . import handle_io, mesh_io, vertex_groups
from .vertex_groups import VertexIndices

if TYPE_CHECKING:
    from .handle_properties import ArapPin


def add_pin(obj: bpy.types.Object, vertices: VertexIndices, name: str = "Pin") -> ArapPin:
    """Makes a vertex group of ``vertices`` (weight 1) and pins it at rest."""
    mesh_io.check_mesh(obj)
    indices = vertex_groups.checked_indices(obj, vertices)
    pin = add_pin_group(obj, vertex_groups.new(obj, indices, name))
    pin.has_made_group = True
    return pin


def add_pin_group(obj: bpy.types.Object, vertex_group: str) -> ArapPin:
    """Pins an existing vertex group; where it is pinned already, returns that pin, enabled."""
    mesh_io.check_mesh(obj)
    vertex_groups.check(obj, vertex_group)
    pins = obj.arap.pins
    pin: ArapPin | None = pins.get(vertex_group)
    if pin is None:
        pin = pins.add()
        pin.name = vertex_group
    pin.is_enabled = True
    obj.arap.active_pin_index = pins.find(vertex_group)
    return pin


def remove_pin(obj: bpy.types.Object, index: int) -> None:
    """Removes a pin, and its vertex group where the pin made it and nothing else uses it."""
    pins = obj.arap.pins
    pin = handle_io.item_at(obj, pins, index, "pin")
    group = pin.name if pin.has_made_group else ""
    pins.remove(index)
    obj.arap.active_pin_index = max(0, min(obj.arap.active_pin_index, len(pins) - 1))
    vertex_groups.remove_unused(obj, group)
