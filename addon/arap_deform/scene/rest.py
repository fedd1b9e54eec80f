# SPDX-License-Identifier: GPL-3.0-or-later
"""The places of handles while the mesh is at rest, and what changes when those change."""

from __future__ import annotations

import bpy
import numpy as np
from mathutils import Matrix

from ..core.arrays import Floats
from .handle_motion import SMALLEST_VOLUME, object_matrix, problem_of, target_matrix


def set_rest_here(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
    """Makes every handle's present place its place at rest."""
    inverse = np.linalg.inv(object_matrix(obj, depsgraph))
    for handle in obj.arap.handles:
        if not problem_of(obj, handle, depsgraph):
            handle.rest = Matrix(inverse @ target_matrix(handle.target, handle.bone, depsgraph))


def follow_new_rest(obj: bpy.types.Object, former: dict[int, Floats]) -> None:
    """Lets stored poses put the handles to the same places as before, now that these are at rest elsewhere.

    Args:
        obj: the mesh, with its new rest matrices.
        former: (4, 4) rest matrices before, by the handles' numbers.
    """
    moved = {
        handle.pose_id: former[handle.pose_id] @ np.linalg.inv(np.array(handle.rest, dtype=np.float64))
        for handle in obj.arap.handles
        if handle.pose_id in former and abs(handle.rest.determinant()) >= SMALLEST_VOLUME
    }
    for pose in obj.arap.poses:
        for item in pose.motions:
            if item.handle_id in moved:
                motion = np.array(item.motion, dtype=np.float64).reshape(4, 4) @ moved[item.handle_id]
                item.motion = motion.ravel().tolist()


def rest_matrices(obj: bpy.types.Object) -> dict[int, Floats]:
    """(4, 4) rest matrices of the handles that a pose may know, by their numbers."""
    return {h.pose_id: np.array(h.rest, dtype=np.float64) for h in obj.arap.handles if h.pose_id}
