# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh as it is seen, with all shape keys and modifiers: what the mouse is over, and which vertices that are.

Read once, and again after the object was evaluated anew; topology only after something else than a pose has changed.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np
from mathutils import Vector
from numpy.typing import NDArray

from ..core.arrays import Floats, Ints
from ..core.transforms import transformed
from ..scene import meshes, versions
from .region import connected_within
from .view import View

# Subdivision, multiresolution, mirror, array and solidify make vertices too, but put the mesh's own ones first.
MAKES_VERTICES = {
    "BEVEL", "BOOLEAN", "BUILD", "DECIMATE", "EDGE_SPLIT", "EXPLODE", "FLUID", "MASK", "MESH_TO_VOLUME", "NODES",
    "OCEAN", "PARTICLE_INSTANCE", "REMESH", "SCREW", "SKIN", "VOLUME_TO_MESH", "WELD", "WIREFRAME",
}  # fmt: skip


@dataclass(frozen=True)
class Topology:
    """How the vertices are joined.

    Attributes:
        edges: (e, 2) int32.
        corner_vertices, face_starts: (c,) and (f + 1,) int32.
    """

    edges: Ints
    corner_vertices: Ints
    face_starts: Ints


@dataclass(frozen=True)
class SeenMesh:
    """One mesh, seen.

    Attributes:
        positions: (n, 3) float64, world space: where the mesh's own vertices are seen.
        is_own: whether what is seen has the mesh's own faces; else modifiers have made others.
    """

    positions: Floats
    topology: Topology
    is_own: bool


@dataclass(frozen=True)
class Pick:
    """What is under the mouse.

    Attributes:
        place, normal: (3,) world, on the surface.
        vertices: (k,) int32 ascending, of the mesh: the patch.
        seeds: vertices of the mesh at the place.
        radius: of the patch in world units.
    """

    place: Floats
    normal: Floats
    vertices: Ints
    seeds: Ints
    radius: float


# By full names of objects: a linked one may have the name of a local one.
_seen: dict[str, SeenMesh] = {}
_topologies: dict[str, tuple[str, Topology]] = {}
"""With the name of the mesh: an object may get another one with as many of everything."""


def view_of(region: bpy.types.Region, region_data: bpy.types.RegionView3D) -> View:
    """The projection of a 3D view."""
    return View(np.array(region_data.perspective_matrix, dtype=np.float64), (region.width, region.height))


def pick(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, view: View, pixel: tuple[float, float], radius_px: float
) -> Pick | None:
    """What of the mesh is under a pixel; None where it is not under it.

    Raises:
        ValueError: what is seen there cannot be traced back to the mesh.
    """
    origin, direction = view.ray(pixel)
    hit = _cast(obj, depsgraph, origin, direction)
    if hit is None:
        return None
    place, normal, face = hit
    seen = read(obj, depsgraph)
    if seen.is_own:
        seeds = seen.topology.corner_vertices[slice(*seen.topology.face_starts[face : face + 2])]
    else:
        seeds = _nearest_own(obj, seen, place)
    radius = radius_px * view.pixel_size(place)
    vertices = connected_within(seen.positions, seen.topology.edges, seeds, place, radius)
    return Pick(place, normal, vertices, seeds, radius)


def read(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> SeenMesh:
    """The mesh as evaluated.

    Raises:
        ValueError: a modifier makes vertices that cannot be traced back.
    """
    seen = _seen.get(obj.name_full)
    if seen is None:
        evaluated = obj.evaluated_get(depsgraph)
        positions = versions.read_positions(evaluated.data)
        n = len(obj.data.vertices)
        is_own = len(positions) == n and len(evaluated.data.polygons) == len(obj.data.polygons)
        if not is_own:
            _check_modifiers(obj, loses_vertices=len(positions) < n)
        world = transformed(meshes.read_matrix(obj, depsgraph), positions[:n])
        seen = _seen[obj.name_full] = SeenMesh(world, _topology(obj), is_own)
    return seen


def _check_modifiers(obj: bpy.types.Object, *, loses_vertices: bool) -> None:
    """Raises ValueError where a modifier makes vertices that cannot be traced back to the mesh."""
    for modifier in obj.modifiers:
        if modifier.show_viewport and (loses_vertices or _is_opaque(modifier)):
            raise ValueError(
                f"What modifier '{modifier.name}' of '{obj.name}' makes cannot be traced back to the mesh: "
                "turn it off in the viewport to pull"
            )


def _is_opaque(modifier: bpy.types.Modifier) -> bool:
    kind = modifier.type
    if kind == "MIRROR":
        return any(modifier.use_bisect_axis)
    if kind == "SOLIDIFY":
        return bool(modifier.solidify_mode != "EXTRUDE")
    return kind in MAKES_VERTICES


def _cast(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, origin: Floats, direction: Floats
) -> tuple[Floats, Floats, int] | None:
    """Place, normal (world) and face of the evaluated mesh that a ray meets first. Blender keeps its tree of faces."""
    evaluated = obj.evaluated_get(depsgraph)
    world = meshes.read_matrix(obj, depsgraph)
    inverse: Floats = np.asarray(np.linalg.inv(world))
    start, along = transformed(inverse, origin), inverse[:3, :3] @ direction
    is_hit, place, normal, face = evaluated.ray_cast(Vector(start), Vector(along / np.linalg.norm(along)))
    if not is_hit or face < 0:
        return None
    outwards = inverse[:3, :3].T @ np.array(normal)
    return transformed(world, np.array(place)), outwards / np.linalg.norm(outwards), int(face)


def _nearest_own(obj: bpy.types.Object, seen: SeenMesh, place: Floats) -> Ints:
    """The mesh's own vertex at a place that is on a face made by modifiers. Raises ValueError where none is near."""
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
    mesh_name, topology = _topologies.get(obj.name_full, ("", None))
    counts = len(mesh.edges), len(mesh.loops), len(mesh.polygons) + 1
    if (
        topology is None
        or mesh_name != mesh.name_full
        or counts != (len(topology.edges), len(topology.corner_vertices), len(topology.face_starts))
    ):
        starts = np.empty(len(mesh.polygons) + 1, dtype=np.int32)
        mesh.polygons.foreach_get("loop_start", starts[:-1])
        starts[-1] = len(mesh.loops)
        topology = Topology(versions.read_edges(mesh), versions.read_corner_vertices(mesh), starts)
        _topologies[obj.name_full] = mesh.name_full, topology
    return topology


def patch_triangles(seen: SeenMesh, vertices: NDArray[np.int32]) -> Ints:
    """(t, 3) vertices of the triangles of all faces whose corners are all among ``vertices``; polygons are fans."""
    topology = seen.topology
    is_inside = np.zeros(len(seen.positions), dtype=bool)
    is_inside[vertices] = True
    starts, sizes = topology.face_starts[:-1], np.diff(topology.face_starts)
    faces = np.flatnonzero(np.logical_and.reduceat(is_inside[topology.corner_vertices], starts))
    n_triangles = sizes[faces] - 2
    first = np.repeat(starts[faces], n_triangles)
    step = np.arange(len(first)) - np.repeat(np.cumsum(n_triangles) - n_triangles, n_triangles)
    corners = np.stack([first, first + step + 1, first + step + 2], axis=1)
    return np.asarray(topology.corner_vertices[corners])


def forget_updated(depsgraph: bpy.types.Depsgraph) -> None:
    """After an evaluation: forgets where what has changed was seen."""
    for update in depsgraph.updates:
        if isinstance(update.id, bpy.types.Object) and (update.is_updated_geometry or update.is_updated_transform):
            _seen.pop(update.id.name_full, None)
            if update.id.mode != "OBJECT":
                _topologies.pop(update.id.name_full, None)


def forget_places() -> None:
    """Another frame: everything may be elsewhere."""
    _seen.clear()


def clear() -> None:
    """Forgets everything: another file, or an undo."""
    _seen.clear()
    _topologies.clear()
