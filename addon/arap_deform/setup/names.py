# SPDX-License-Identifier: GPL-3.0-or-later
"""A name for a new pin or handle: that of the artist's vertex group which it is a part of, else its side and place."""

from __future__ import annotations

import bpy
import numpy as np

from ..core.arrays import Floats, Ints
from ..core.transforms import transformed
from ..scene import meshes

MOST_WEIGHTS = 20_000_000  # vertices times groups: to read more takes too long
LEAST_SHARE = 0.5  # mean weight of the vertices in a group that gives its name
BESIDE = 0.1  # from this fraction of the half width on, a piece is on one side
OFF_CENTRE = 0.25  # the same of depth and height, and not in the middle

# Blender's figures look along -Y, so their left is at +X. For Y and Z: the name at the low end, and at the high end.
ENDS = ((1, ("Front", "Back")), (2, ("Bottom", "Top")))


def name_for(obj: bpy.types.Object, vertices: Ints) -> str:
    """Hand.L for example. Two pieces may get one name. Sides are those of the world: the object may be turned."""
    world = meshes.read_matrix(obj, bpy.context.evaluated_depsgraph_get())
    rest = transformed(world, meshes.read_rest(obj).astype(np.float64))
    return _group_of(obj, vertices) or place_name(rest[vertices], rest.min(axis=0), rest.max(axis=0))


def _group_of(obj: bpy.types.Object, vertices: Ints) -> str:
    """The vertex group with most weight on the vertices, of those that the add-on has not made; '' if it is little."""
    settings = obj.arap
    made = {entry.name for entry in settings.stiffness if entry.has_made_group}
    made |= {control.vertex_group for control in settings.controls if control.has_made_group}
    names = [group.name for group in obj.vertex_groups if group.name not in made]
    if not names or len(names) * len(obj.data.vertices) > MOST_WEIGHTS:
        return ""
    weights = meshes.read_weights(obj, names)
    share, name = max((float(weights[name][vertices].mean()), name) for name in names)
    return name if share >= LEAST_SHARE else ""


def place_name(points: Floats, low: Floats, high: Floats) -> str:
    """Top, Bottom, Front, Back or Middle, with .L or .R beside the middle.

    Args:
        points: (k, 3) of the piece, in the axes of the world.
        low, high: (3,) corners of the box of the mesh.
    """
    half = (high - low) / 2.0
    offset = points.mean(axis=0) - (low + high) / 2.0
    offset = [float(offset[i] / half[i]) if half[i] > 0.0 else 0.0 for i in range(3)]
    side = ".L" if offset[0] > BESIDE else ".R" if offset[0] < -BESIDE else ""
    axis, ends = max(ENDS, key=lambda end: abs(offset[end[0]]))
    place = "Middle" if abs(offset[axis]) < OFF_CENTRE else ends[offset[axis] > 0.0]
    return place + side
