# SPDX-License-Identifier: GPL-3.0-or-later
"""The points of a curve or NURBS surface in arrays.

A point of a Bezier spline counts three times. First come all points, then all left handles, then all right ones.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy
import numpy as np

from ...core.arrays import Float32s, Ints
from ..versions import fields_of


def check_one_type(obj: bpy.types.Object) -> None:
    """Raises ValueError if only some splines have handles. Blender gives no quick way to their shape keys."""
    if len({spline.type == "BEZIER" for spline in obj.data.splines}) > 1:
        raise ValueError(
            f"'{obj.name}' has Bezier splines and others: make them one type (in Edit Mode: Curve > Set Spline Type)"
        )


def count(curve: bpy.types.Curve) -> int:
    """How many points there are, with their handles. Quick, as each frame asks it."""
    along, across = (np.empty(len(curve.splines), dtype=np.int32) for _ in range(2))
    curve.splines.foreach_get("point_count_u", along)
    curve.splines.foreach_get("point_count_v", across)  # 0 or 1, but for a surface
    first = next(_points_of(curve), ())
    return int(along @ np.maximum(across, 1)) * len(fields_of(first))


def read_positions(curve: bpy.types.Curve) -> Float32s:
    """(n, 3) coordinates of the curve itself, without shape keys. All splines have one type, see check_one_type()."""
    groups = list(_points_of(curve))
    if not groups:
        return np.empty((0, 3), dtype=np.float32)
    fields = fields_of(groups[0])
    return np.concatenate([_read(points, field)[:, :3] for field in fields for points in groups])


def write_positions(curve: bpy.types.Curve, positions: Float32s) -> None:
    """Writes (n, 3) coordinates to the curve itself; the caller tags it."""
    groups, start = list(_points_of(curve)), 0
    for field in fields_of(groups[0]):
        for points in groups:
            values = _read(points, field)
            values[:, :3] = positions[start : start + len(points)]
            points.foreach_set(field, values.ravel())
            start += len(points)


def spline_of_point(curve: bpy.types.Curve) -> Ints:
    """(n,) the number of the spline of each point."""
    groups = list(_points_of(curve))
    of_point = np.repeat(np.arange(len(groups), dtype=np.int32), [len(points) for points in groups])
    return np.tile(of_point, len(fields_of(groups[0])))


def _points_of(curve: bpy.types.Curve) -> Iterator[Any]:
    for spline in curve.splines:
        yield spline.bezier_points if spline.type == "BEZIER" else spline.points


def _read(points: Any, field: str) -> Float32s:
    """(k, 3), or (k, 4) with the weights of a NURBS curve."""
    values = np.empty((len(points), len(getattr(points[0], field))), dtype=np.float32)
    points.foreach_get(field, values.ravel())
    return values
