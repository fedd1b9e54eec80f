# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays of an object for the overlay. Read only after a change, not for each redraw."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import sessions
from ..core.arrays import Float32s
from ..props.bounds import bounded
from ..scene import handle_motion, meshes, pose_key, versions
from .strain import EdgeStrain, colors_of


@dataclass(frozen=True)
class Surface:
    """The data that posing does not change.

    Attributes:
        rest: (n, 3) float32.
        triangles: (t, 3) int32.
    """

    rest: Float32s
    triangles: NDArray[np.int32]
    strain: EdgeStrain

    @classmethod
    def read(cls, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Surface:
        """Of a mesh in any mode but Edit Mode. Raises ValueError if the object is scaled to nothing."""
        mesh = obj.data
        mesh.calc_loop_triangles()
        triangles = np.empty((len(mesh.loop_triangles), 3), dtype=np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles.ravel())
        rest = meshes.read_rest(obj)
        strain = EdgeStrain(rest, versions.read_edges(obj.data), meshes.read_stretch(obj, depsgraph))
        return cls(rest, triangles, strain)

    def fits(self, obj: bpy.types.Object) -> bool:
        return len(obj.data.vertices) == len(self.rest)


def read_pinned(obj: bpy.types.Object) -> NDArray[np.int32]:
    """(p,) int32 vertices of the enabled pins."""
    pinned = (pin.vertex_group for pin in obj.arap.pins if pin.is_enabled)
    names = [group for group in pinned if group in obj.vertex_groups]
    # Reading with nodes would add data to the scene, which Blender forbids while drawing.
    weights = meshes.read_weights(obj, names, use_nodes=False)
    is_pinned = np.zeros(len(obj.data.vertices), dtype=bool)
    for values in weights.values():
        is_pinned |= values > 0.0
    return np.flatnonzero(is_pinned).astype(np.int32)


def positions_now(obj: bpy.types.Object, surface: Surface, depsgraph: bpy.types.Depsgraph) -> Float32s:
    """(n, 3) float32 as seen, object space. If modifiers change the number of vertices: the pose before them."""
    evaluated = obj.evaluated_get(depsgraph).data
    if len(evaluated.vertices) == len(surface.rest):
        return versions.read_positions(evaluated)
    return pose_key.shown_positions(obj, surface.rest)


def strain_colors(obj: bpy.types.Object, surface: Surface) -> Float32s:
    """(n, 4) float32 RGBA, of the pose without other shape keys and modifiers."""
    shown = pose_key.shown_positions(obj, surface.rest)
    return colors_of(surface.strain.of(shown), bounded(obj.arap.overlay, "strain_limit") / 100.0)


def cube_edges(obj: bpy.types.Object) -> Float32s:
    """(2 e, 3) float32, object space: of its live session's lattice; none without one, or while it is at work."""
    bound = sessions.get(obj.session_uid)
    if bound is not None:
        with suppress(RuntimeError):
            return bound.session.cube_edges()
    return np.empty((0, 3), dtype=np.float32)


def handle_lines(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Float32s:
    """(2 h, 3) float32, world space: the place at rest and now of each enabled handle that works."""
    matrix = meshes.read_matrix(obj, depsgraph)
    ends = []
    for handle in obj.arap.handles:
        if handle.is_enabled and not handle_motion.problem_of(obj, handle, depsgraph):
            at_rest = matrix @ np.array(handle.rest, dtype=np.float64)
            now = handle_motion.target_matrix(handle.target, handle.bone, depsgraph)
            ends += [at_rest[:3, 3], now[:3, 3]]
    return np.array(ends, dtype=np.float32).reshape(-1, 3)
