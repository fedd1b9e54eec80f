# SPDX-License-Identifier: GPL-3.0-or-later
"""The lists of an object whose entries are vertex groups, pins and stiffness: entries made, found and removed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy

from ..scene import groups, meshes
from ..scene.groups import VertexIndices


@dataclass(frozen=True)
class GroupList:
    """One of these lists, of whatever object.

    Attributes:
        noun: what an entry is called in messages.
        items, active: the list and the index of the entry chosen in it, by their names in ``obj.arap``.
    """

    noun: str
    items: str
    active: str

    def add_vertices(self, obj: bpy.types.Object, vertices: VertexIndices, name: str) -> Any:
        """A new entry with a vertex group of its own, of ``vertices`` with weight 1."""
        meshes.check_mesh(obj)
        indices = groups.checked_indices(obj, vertices)
        item = self.add_group(obj, groups.new(obj, indices, name))
        item.has_made_group = True
        return item

    def add_group(self, obj: bpy.types.Object, vertex_group: str) -> Any:
        """The entry of an existing vertex group, made where there is none yet; enabled and chosen."""
        meshes.check_mesh(obj)
        groups.check(obj, vertex_group)
        items = getattr(obj.arap, self.items)
        item = items.get(vertex_group)
        if item is None:
            item = items.add()
            item.name = vertex_group
        item.is_enabled = True
        setattr(obj.arap, self.active, items.find(vertex_group))
        return item

    def remove(self, obj: bpy.types.Object, index: int) -> None:
        """Takes an entry off, and its vertex group where the entry made it and nothing else uses it."""
        items = getattr(obj.arap, self.items)
        item = item_at(obj, items, index, self.noun)
        group = item.name if item.has_made_group else ""
        items.remove(index)
        setattr(obj.arap, self.active, max(0, min(getattr(obj.arap, self.active), len(items) - 1)))
        groups.remove_unused(obj, group)


def item_at(obj: bpy.types.Object, items: Sequence[Any], index: int, noun: str) -> Any:
    """``items[index]`` of a list of the object. Raises ValueError where there is none."""
    if not 0 <= index < len(items):
        raise ValueError(f"'{obj.name}' has no {noun} {index}: it has {len(items)}")
    return items[index]
