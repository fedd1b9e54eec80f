# SPDX-License-Identifier: GPL-3.0-or-later
"""How large a mesh is at rest, as seen. The answer is kept until the mesh or its scale changes."""

from __future__ import annotations

from collections.abc import Container

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.patches import surface_diagonal
from . import meshes, versions

SAME_STRETCH = 1e-5  # relative; the matrix of a turning object differs by less


_known: dict[str, tuple[Floats, float]] = {}
"""The stretch, scaled to a largest entry of 1, and the diagonal under it, by full names of objects: a linked one may
have the name of a local one."""


def diagonal(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> float:
    """Diagonal of the box of the vertices that are in faces, at rest and with the object's stretch, in scene units.

    Raises:
        ValueError: the object is scaled to nothing.
    """
    stretch = meshes.read_stretch(obj, depsgraph)
    scale = float(np.abs(stretch).max())
    shape = stretch / scale
    former = _known.get(obj.name_full)
    if former is None or np.abs(former[0] - shape).max() > SAME_STRETCH:
        corner_vertices = versions.read_corner_vertices(obj.data)
        former = (shape, surface_diagonal(meshes.read_rest(obj) @ shape.T, corner_vertices))
        _known[obj.name_full] = former
    return scale * former[1]


def forget_updated(depsgraph: bpy.types.Depsgraph, posed: Container[str]) -> None:
    """After an evaluation: forgets what has changed, except the ``posed`` objects: their rest shape stays."""
    if _known:
        for update in depsgraph.updates:
            # Acts have objects of this file, whose full name is their name.
            is_posed = update.id.name_full in posed
            if update.is_updated_geometry and isinstance(update.id, bpy.types.Object) and not is_posed:
                _known.pop(update.id.name_full, None)


def clear() -> None:
    """Forgets everything: another file, or an undo."""
    _known.clear()
