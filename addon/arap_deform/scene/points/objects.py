# SPDX-License-Identifier: GPL-3.0-or-later
"""The points of any object that has shape keys and can be attached."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ...core.arrays import Float32s, Ints
from ...core.attach.pieces import loose_pieces
from .. import versions
from . import curves

KINDS = ("MESH", "CURVE", "SURFACE")


def has_points(obj: bpy.types.Object) -> bool:
    """Whether the object is a mesh, a curve or a NURBS surface."""
    return obj.type in KINDS


def check(obj: bpy.types.Object) -> None:
    """Raises ValueError if there are no points, or none that can be read."""
    n = count(obj)
    if not n:
        noun = "vertices" if obj.type == "MESH" else "points"
        raise ValueError(f"'{obj.name}' has no {noun}: there is nothing to attach")
    if obj.type == "MESH":
        return
    curves.check_one_type(obj)
    # Object > Join and scripts that change splines leave shape keys as they are. Edit Mode makes them fit.
    if obj.data.shape_keys is not None and n != curves.count(obj.data):
        raise ValueError(f"The shape keys of '{obj.name}' do not fit its splines: go to Edit Mode and back")


def count(obj: bpy.types.Object) -> int:
    """How many there are. Quick, if a curve has shape keys."""
    if obj.type == "MESH":
        return len(obj.data.vertices)
    keys = obj.data.shape_keys
    return versions.key_size(keys.reference_key) if keys is not None else curves.count(obj.data)


def read_positions(data: bpy.types.Mesh | bpy.types.Curve) -> Float32s:
    """(n, 3) coordinates of a mesh or a curve itself, without shape keys."""
    is_mesh = isinstance(data, bpy.types.Mesh)
    return versions.read_positions(data) if is_mesh else curves.read_positions(data)


def read_positions_at(data: bpy.types.Mesh | bpy.types.Curve, rows: Sequence[int]) -> Float32s:
    """(k, 3) some rows of read_positions(), quicker for a mesh."""
    if not isinstance(data, bpy.types.Mesh):
        return curves.read_positions(data)[rows]
    return np.array([data.vertices[row].co for row in rows], dtype=np.float32).reshape(-1, 3)


def write_positions(data: bpy.types.Mesh | bpy.types.Curve, positions: Float32s) -> None:
    """Writes (n, 3) contiguous float32 coordinates to a mesh or a curve itself; the caller tags it."""
    if isinstance(data, bpy.types.Mesh):
        versions.write_positions(data, positions)
    else:
        curves.write_positions(data, positions)


def pieces(obj: bpy.types.Object) -> Ints:
    """(n,) the loose piece of each point, a number from 0 that may leave gaps: of a curve, its splines."""
    if obj.type == "MESH":
        return loose_pieces(len(obj.data.vertices), versions.read_edges(obj.data))
    return curves.spline_of_point(obj.data)
