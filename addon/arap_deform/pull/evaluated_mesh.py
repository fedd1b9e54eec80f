# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh as it is seen, with all shape keys and modifiers, and the vertices under the mouse.

Positions are read again after each evaluation of the object, topology only after the mesh itself has changed.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Floats, Ints
from ..core.graph import fans
from ..core.transforms import transformed
from ..scene import known, meshes, versions
from .ray import cast
from .region import connected_within
from .view import View

# Subdivision, multiresolution, mirror, array and solidify make vertices too, but the mesh's own vertices come first.
MAKES_VERTICES = {
    "BEVEL", "BOOLEAN", "BUILD", "DECIMATE", "EDGE_SPLIT", "EXPLODE", "FLUID", "MASK", "MESH_TO_VOLUME", "NODES",
    "OCEAN", "PARTICLE_INSTANCE", "REMESH", "SCREW", "SKIN", "VOLUME_TO_MESH", "WELD", "WIREFRAME",
}  # fmt: skip


@dataclass(frozen=True)
class Topology:
    """How the vertices are connected.

    Attributes:
        edges: (e, 2) int32.
        corner_vertices, face_starts: (c,) and (f + 1,) int32.
    """

    edges: Ints
    corner_vertices: Ints
    face_starts: Ints


@dataclass(frozen=True, eq=False)  # equal is the same one only
class EvaluatedMesh:
    """A mesh as it is seen.

    Attributes:
        positions: (n, 3) float64, world space, of the mesh's own vertices.
        is_own: whether the evaluated mesh has the mesh's own faces; else modifiers have made others.
    """

    positions: Floats
    topology: Topology
    is_own: bool


@dataclass(frozen=True)
class PickedPatch:
    """The surface under the mouse.

    Attributes:
        place, normal: (3,) world, on the surface.
        vertices: (k,) int32 ascending, the patch.
        seeds: vertices of the face at the place.
        radius: of the patch, in world units.
    """

    place: Floats
    normal: Floats
    vertices: Ints
    seeds: Ints
    radius: float


_seen: dict[int, EvaluatedMesh] = {}
"""By uid of the object."""
_topologies: dict[int, tuple[int, Topology]] = {}
"""By uid of the object, with that of its mesh: it may get another one with the same counts."""


def view_of(region: bpy.types.Region, region_data: bpy.types.RegionView3D) -> View:
    """The projection of a 3D view."""
    return View(np.array(region_data.perspective_matrix, dtype=np.float64), (region.width, region.height))


def pick(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, view: View, pixel: tuple[float, float], radius_px: float
) -> PickedPatch | None:
    """The part of the mesh under a pixel, or near what is there and is attached to it; None if neither is there.

    Raises:
        ValueError: modifiers have made the surface there, and no vertex of the mesh belongs to it.
    """
    origin, direction = view.ray(pixel)
    hit = cast(obj, depsgraph, origin, direction)
    if hit is None:
        return None
    seen = read(obj, depsgraph)
    if seen.is_own:
        seeds = seen.topology.corner_vertices[slice(*seen.topology.face_starts[hit.face : hit.face + 2])]
    else:
        seeds = _nearest_own(obj, seen, hit.place)
    radius = radius_px * view.pixel_size(hit.place)
    vertices = connected_within(seen.positions, seen.topology.edges, seeds, hit.place, radius)
    return PickedPatch(hit.place, hit.normal, vertices, seeds, radius)


def read(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> EvaluatedMesh:
    """The evaluated mesh.

    Raises:
        ValueError: a modifier makes vertices that cannot be traced back to the mesh.
    """
    seen = _seen.get(obj.session_uid)
    if seen is None:
        evaluated = obj.evaluated_get(depsgraph)
        positions = versions.read_positions(evaluated.data)
        n = len(obj.data.vertices)
        is_own = len(positions) == n and len(evaluated.data.polygons) == len(obj.data.polygons)
        if not is_own:
            _check_modifiers(obj, loses_vertices=len(positions) < n)
        world = transformed(meshes.read_matrix(obj, depsgraph), positions[:n])
        seen = _seen[known.add(obj)] = EvaluatedMesh(world, _topology(obj), is_own)
    return seen


def _check_modifiers(obj: bpy.types.Object, *, loses_vertices: bool) -> None:
    """Raises ValueError if a modifier makes vertices that cannot be traced back to the mesh."""
    for modifier in obj.modifiers:
        if modifier.show_viewport and (loses_vertices or _is_opaque(modifier)):
            raise ValueError(
                f"Modifier '{modifier.name}' of '{obj.name}' makes other vertices: turn it off in the viewport to pull"
            )


def _is_opaque(modifier: bpy.types.Modifier) -> bool:
    kind = modifier.type
    if kind == "MIRROR":
        return any(modifier.use_bisect_axis)
    if kind == "SOLIDIFY":
        return bool(modifier.solidify_mode != "EXTRUDE")
    return kind in MAKES_VERTICES


def _nearest_own(obj: bpy.types.Object, seen: EvaluatedMesh, place: Floats) -> Ints:
    """The mesh's own vertex at a place on a face that modifiers have made. Raises ValueError if none is near."""
    distance = np.linalg.norm(seen.positions - place, axis=1)
    nearest = int(distance.argmin())
    edges = seen.topology.edges
    around = edges[(edges == nearest).any(axis=1)]
    lengths = np.linalg.norm(seen.positions[around[:, 0]] - seen.positions[around[:, 1]], axis=1)
    if not len(lengths) or distance[nearest] > lengths.max():
        raise ValueError(f"This part of '{obj.name}' is made by a modifier: pull the mesh itself")
    return np.array([nearest], dtype=np.int32)


def _topology(obj: bpy.types.Object) -> Topology:
    mesh = obj.data
    mesh_uid, topology = _topologies.get(obj.session_uid, (0, None))
    counts = len(mesh.edges), len(mesh.loops), len(mesh.polygons) + 1
    if (
        topology is None
        or mesh_uid != mesh.session_uid
        or counts != (len(topology.edges), len(topology.corner_vertices), len(topology.face_starts))
    ):
        starts = np.empty(len(mesh.polygons) + 1, dtype=np.int32)
        mesh.polygons.foreach_get("loop_start", starts[:-1])
        starts[-1] = len(mesh.loops)
        topology = Topology(versions.read_edges(mesh), versions.read_corner_vertices(mesh), starts)
        _topologies[known.add(obj)] = mesh.session_uid, topology
    return topology


def patch_triangles(seen: EvaluatedMesh, vertices: NDArray[np.int32]) -> Ints:
    """(t, 3) vertices of the triangles of all faces inside ``vertices``; polygons become fans."""
    topology = seen.topology
    is_inside = np.zeros(len(seen.positions), dtype=bool)
    is_inside[vertices] = True
    starts, sizes = topology.face_starts[:-1], np.diff(topology.face_starts)
    faces = np.flatnonzero(np.logical_and.reduceat(is_inside[topology.corner_vertices], starts))
    return fans(topology.corner_vertices, starts[faces], sizes[faces])


def forget_updated(update: known.Update) -> None:
    """After an evaluation: forgets an object that has changed."""
    if update.is_deformed or update.is_moved:
        _seen.pop(update.uid, None)
        if update.obj.mode != "OBJECT":
            _topologies.pop(update.uid, None)


def forget_places() -> None:
    """In another frame everything may have moved."""
    _seen.clear()


def clear() -> None:
    """After a file load or an undo."""
    _seen.clear()
    _topologies.clear()
