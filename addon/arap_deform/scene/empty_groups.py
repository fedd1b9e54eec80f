# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertex groups have no weights, for panels. The answer is kept until the mesh changes."""

from __future__ import annotations

import bpy

from . import versions

# With more vertices the look takes longer than a panel may. Then preparing the pose tells of empty groups.
MOST_VERTICES = 20_000

_has_weights: dict[str, dict[str, bool]] = {}
"""By full names of objects (a linked one may have the name of a local one) and names of groups."""


def is_empty(obj: bpy.types.Object, group: str) -> bool:
    """Whether no vertex has weight in that group of ``obj``; False too if the look would take more than milliseconds.

    It is right after Blender has evaluated the scene, as it does before it draws.
    """
    if obj.mode != "OBJECT" or group not in obj.vertex_groups or len(obj.data.vertices) > MOST_VERTICES:
        return False
    if group not in _has_weights.get(obj.name_full, {}):
        # All groups at once. Not by nodes: they add to the scene, and drawing must not.
        weights = versions.read_group_weights(obj, obj.vertex_groups.keys(), use_nodes=False)
        _has_weights[obj.name_full] = {name: bool(values.any()) for name, values in weights.items()}
    return not _has_weights[obj.name_full][group]


def forget_updated(depsgraph: bpy.types.Depsgraph) -> None:
    """After an evaluation: forgets what has changed."""
    if not _has_weights:
        return
    for update in depsgraph.updates:
        if update.is_updated_geometry and isinstance(update.id, bpy.types.Object):
            _has_weights.pop(update.id.name_full, None)


def clear() -> None:
    """Forgets everything: another file, or an undo."""
    _has_weights.clear()
