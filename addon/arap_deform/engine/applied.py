# SPDX-License-Identifier: GPL-3.0-or-later
"""After Object > Apply to a mesh, what its handles have saved is told in its new coordinates: nothing moves.

Blender does not tell of Apply. So each mesh with handles keeps its own matrix and a few vertices at rest, as they were
seen last: they are saved, as an undo may bring back the moment between Apply and the look at it.
"""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from ..core.arrays import Floats
from ..core.attach.probe import probed
from ..core.transforms import applied_map, has_no_inverse, inverted
from ..props import hooks
from ..props.base_shape import turn_bases
from ..scene import known, meshes
from ..scene.registration import for_each
from .scene import is_rendering


def look(obj: bpy.types.Object) -> None:
    """Notes where the mesh is now. If it got there by Object > Apply, what is saved is moved too."""
    if obj.type != "MESH" or not obj.arap.controls or obj.library is not None or meshes.is_override(obj):
        return
    if obj.data.is_editmode or is_rendering():
        return
    settings = obj.arap
    points = meshes.read_rest_at(obj, probed(len(obj.data.vertices)))
    matrix = np.array(obj.matrix_basis, dtype=np.float64)
    former_points = np.array(settings.last_points, dtype=np.float32)[: points.size].reshape(-1, 3)
    former_matrix = np.array(settings.last_matrix, dtype=np.float64).reshape(4, 4)
    to_now = applied_map(former_matrix, former_points, matrix, points)
    if to_now is not None:
        _take_along(obj, to_now)
    if not np.array_equal(former_matrix, matrix):
        settings.last_matrix = matrix.ravel()
    if not np.array_equal(former_points, points):
        settings.last_points = np.resize(points.ravel(), len(settings.last_points))


def _take_along(obj: bpy.types.Object, to_now: Floats) -> None:
    """``to_now``: (4, 4) from the former coordinates of the mesh to the present ones."""
    settings = obj.arap
    is_flat = has_no_inverse(to_now)
    turn_bases(obj.data, to_now[:3, :3])
    for handle in settings.handles:
        if is_flat:  # where it rests on a flat mesh cannot be told, and its list says so
            handle.rest_matrix = (0.0,) * 16
            continue
        handle.rest = Matrix(to_now @ np.array(handle.rest, dtype=np.float64))
    if is_flat:
        return
    back = inverted(to_now)
    for motion in (motion for pose in settings.poses for motion in pose.motions):
        former = np.array(motion.motion, dtype=np.float64).reshape(4, 4)
        motion.motion = (to_now @ former @ back).ravel()


def _on_control_changed(obj: bpy.types.Object, _control: object) -> None:
    look(obj)


def updated(update: known.Update) -> None:
    """After an evaluation."""
    if update.is_moved or update.is_deformed:
        look(update.obj)


def replaced() -> None:
    """After an undo or the load of a file."""
    for_each(known.all_objects(), look)


CALLBACKS = ((hooks.control_changed, _on_control_changed),)
