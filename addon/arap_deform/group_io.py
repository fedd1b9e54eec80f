# SPDX-License-Identifier: GPL-3.0-or-later
"""The vertex groups of pins and handles: making them of vertices, removing those that nothing uses any more."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

VertexIndices = Sequence[int] | NDArray[np.integer]


def checked_indices(obj: bpy.types.Object, vertices: VertexIndices) -> NDArray[np.int32]:
    """(k,) ascending. Raises ValueError where they are no vertices of the mesh."""
    indices: NDArray[np.integer] = np.unique(np.asarray(vertices))
    n = len(obj.data.vertices)
    if not indices.size:
        raise ValueError(f"No vertices of '{obj.name}' were given: select some")
    if indices.dtype.kind not in "iu":
        raise ValueError(f"Vertices of '{obj.name}' must be whole numbers, not {indices.dtype}")
    if indices[0] < 0 or indices[-1] >= n:
        wrong = indices[0] if indices[0] < 0 else indices[-1]
        raise ValueError(f"'{obj.name}' has no vertex {wrong}: its vertices are 0 to {n - 1}")
    return indices.astype(np.int32)


def check_group(obj: bpy.types.Object, vertex_group: str) -> None:
    """Raises ValueError where the object has no such group."""
    if vertex_group not in obj.vertex_groups:
        raise ValueError(f"'{obj.name}' has no vertex group '{vertex_group}': choose one of its groups")


def new_group(obj: bpy.types.Object, indices: NDArray[np.int32], name: str) -> str:
    """A group with weight 1 at these vertices; its name, which Blender may have numbered."""
    group = obj.vertex_groups.new(name=name)
    group.add(indices.tolist(), 1.0, "REPLACE")
    return str(group.name)


def remove_group(obj: bpy.types.Object, name: str) -> None:
    """Removes a vertex group that nothing of the object uses any more; '' is none."""
    group = obj.vertex_groups.get(name) if name else None
    if group is None:
        return
    settings = obj.arap
    keys = obj.data.shape_keys.key_blocks if obj.data.shape_keys else ()
    used = {pin.name for pin in settings.pins} | {handle.vertex_group for handle in settings.handles}
    used |= {settings.rigid_group, settings.stiffness_group} | {key.vertex_group for key in keys}
    used |= {getattr(modifier, "vertex_group", "") for modifier in obj.modifiers}
    if name not in used:
        obj.vertex_groups.remove(group)


def item_at(obj: bpy.types.Object, items: Sequence[Any], index: int, noun: str) -> Any:
    """``items[index]``; a ValueError says what there is where there is none."""
    if not 0 <= index < len(items):
        raise ValueError(f"'{obj.name}' has no {noun} {index}: it has {len(items)}")
    return items[index]
