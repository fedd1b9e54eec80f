# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a ray meets a mesh, or what is attached to it: a drag on a shirt pulls the body, near that place."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector

from ..attach.problems import below
from ..core.arrays import Floats
from ..core.transforms import has_no_inverse, inverted, transformed
from ..scene import meshes


@dataclass(frozen=True)
class RayHit:
    """A place on an evaluated mesh.

    Attributes:
        place, normal: (3,) world.
        face: its number.
    """

    place: Floats
    normal: Floats
    face: int


def cast(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, origin: Floats, direction: Floats) -> RayHit | None:
    """Where a ray meets the mesh first; None if it meets neither that nor what is attached to it.

    If it meets what is attached to the mesh before: the place of the mesh that is nearest to there.
    """
    own = _cast(obj, depsgraph, origin, direction)
    if own is not None and obj.arap.is_stand_in:
        return own  # it is where its meshes are, and to look at these may take long
    found = own
    for attached in below(obj):
        # Blender 4.5 and 5.2 crash if a ray is cast at a curve without faces.
        if attached.type == "MESH" and attached.visible_get():
            hit = _cast(attached, depsgraph, origin, direction)
            if hit is not None and (found is None or (hit.place - found.place) @ direction < 0.0):
                found = hit
    return own if found is own or found is None else _nearest(obj, depsgraph, found.place)


def _cast(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, origin: Floats, direction: Floats) -> RayHit | None:
    evaluated = obj.evaluated_get(depsgraph)
    world = meshes.read_matrix(obj, depsgraph)
    if has_no_inverse(world):
        return None  # scaled to nothing, as what an artist hides in an animation
    inverse: Floats = inverted(world)
    start, along = transformed(inverse, origin), inverse[:3, :3] @ direction
    is_hit, place, normal, face = evaluated.ray_cast(Vector(start), Vector(along / np.linalg.norm(along)))
    return _seen(world, place, normal, face) if is_hit and face >= 0 else None


def _nearest(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, place: Floats) -> RayHit | None:
    world = meshes.read_matrix(obj, depsgraph)
    if has_no_inverse(world):
        return None
    start = transformed(inverted(world), place)
    is_found, nearest, normal, face = obj.evaluated_get(depsgraph).closest_point_on_mesh(Vector(start))
    return _seen(world, nearest, normal, face) if is_found and face >= 0 else None


def _seen(world: Floats, place: Vector, normal: Vector, face: int) -> RayHit:
    outwards = inverted(world)[:3, :3].T @ np.array(normal)
    length = np.linalg.norm(outwards)
    return RayHit(transformed(world, np.array(place)), outwards / (length if length > 0.0 else 1.0), int(face))
