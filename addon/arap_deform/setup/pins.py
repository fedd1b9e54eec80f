# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins of an object: added and removed. And what the lists of pins, handles and stiffness share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import bpy

from ..props.base_shape import BaseShape
from ..scene import groups, meshes, staying
from ..scene.groups import VertexIndices

if TYPE_CHECKING:
    from ..props.handles import ArapPin


@dataclass(frozen=True)
class GroupList:
    """One of these lists, of any object.

    Attributes:
        noun: the name of an entry in messages.
        items, active: names in ``obj.arap`` of the list and of the index of its chosen entry.
        group: the field of an entry with the name of its vertex group.
    """

    noun: str
    items: str
    active: str
    group: str = "name"

    def add_vertices(self, obj: bpy.types.Object, vertices: VertexIndices, name: str) -> Any:
        """A new entry with its own vertex group of ``vertices``, weight 1."""
        meshes.check_mesh(obj)
        meshes.check_local(obj)
        indices = groups.checked_indices(obj, vertices)
        item = self.add_group(obj, groups.new(obj, indices, name))
        item.has_made_group = True
        return item

    def add_group(self, obj: bpy.types.Object, vertex_group: str) -> Any:
        """The entry of an existing vertex group, added if missing; enabled and chosen."""
        meshes.check_mesh(obj)
        meshes.check_local(obj)
        groups.check(obj, vertex_group)
        items = getattr(obj.arap, self.items)
        item = items.get(vertex_group)
        if item is None:
            item = items.add()
            item.name = vertex_group
            count_rows(obj)
        item.is_enabled = True
        setattr(obj.arap, self.active, items.find(vertex_group))
        return item

    def at(self, obj: bpy.types.Object, index: int) -> Any:
        """An entry. Raises ValueError if there is none."""
        items = getattr(obj.arap, self.items)
        if not isinstance(index, int):
            raise ValueError(  # noqa: TRY004 - the errors of scripts are ValueError and RuntimeError
                f"{index!r} is no index: give the number of the {self.noun}, from 0"
            )
        if not 0 <= index < len(items):
            raise ValueError(f"'{obj.name}' has no {self.noun} {index}: it has {len(items)}")
        return items[index]

    def remove(self, obj: bpy.types.Object, index: int) -> None:
        """Removes an entry, and its vertex group if the entry made it and nothing else uses it."""
        meshes.check_local(obj)
        items = getattr(obj.arap, self.items)
        item = self.at(obj, index)
        group = getattr(item, self.group) if item.has_made_group else ""
        if isinstance(item, BaseShape):
            item.forget_base()
        items.remove(index)
        count_rows(obj)
        setattr(obj.arap, self.active, max(0, min(getattr(obj.arap, self.active), len(items) - 1)))
        groups.remove_unused(obj, group)


def count_rows(obj: bpy.types.Object) -> None:
    """As many rows as there are handles and pins."""
    rows, n = obj.arap.rows, len(obj.arap.handles) + len(obj.arap.pins)
    while len(rows) < n:
        rows.add()
    while len(rows) > n:
        rows.remove(len(rows) - 1)


PINS = GroupList("pin", "pins", "active_pin_index")


def add_pin(obj: bpy.types.Object, vertices: VertexIndices, name: str = "Pin") -> ArapPin:
    """Makes a vertex group of ``vertices`` (weight 1) and pins it where it is shown."""
    pin: ArapPin = PINS.add_vertices(obj, vertices, name)
    staying.stay(obj, None, pin)
    return pin


def add_pin_group(obj: bpy.types.Object, vertex_group: str) -> ArapPin:
    """Pins an existing vertex group where it is shown. If it is pinned already, returns that pin, enabled."""
    former = obj.arap.pins.get(vertex_group)
    was_enabled = former is not None and former.is_enabled
    pin: ArapPin = PINS.add_group(obj, vertex_group)
    if not was_enabled:
        staying.stay(obj, None, pin)
    return pin


def remove_pin(obj: bpy.types.Object, index: int) -> None:
    """Removes a pin, and its vertex group if the pin made it and nothing else uses it."""
    PINS.remove(obj, index)
