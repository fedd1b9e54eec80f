# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes to measure on: the sample creature at any size, and files that the caller names."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scenes.creature import creature_arrays

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]


class Mesh(NamedTuple):
    """A polygon mesh.

    Attributes:
        name: as it appears in tables.
        positions: (n, 3) float64, bounding-box diagonal 1.
        corner_vertices: (c,) int32, the faces' vertices, one face after the other.
        face_sizes: (f,) int32.
    """

    name: str
    positions: Floats
    corner_vertices: Ints
    face_sizes: Ints

    @property
    def triangles(self) -> Ints:
        """(f, 3) int32; only of a mesh of triangles."""
        return self.corner_vertices.reshape(-1, 3)


def make_mesh(name: str, positions: Floats, faces: Ints) -> Mesh:
    """A mesh of faces (f, k) that all have k corners, scaled to a diagonal of 1."""
    diagonal = float(np.linalg.norm(np.ptp(positions, axis=0)))
    if not diagonal > 0.0:
        raise ValueError(f"{name}: all vertices are at one place")
    return unscaled(name, positions / diagonal, faces)


def unscaled(name: str, positions: Floats, faces: Ints) -> Mesh:
    """A mesh of faces (f, k) that all have k corners, its positions as they are."""
    sizes = np.full(len(faces), faces.shape[1], dtype=np.int32)
    return Mesh(name, positions, np.ascontiguousarray(faces.ravel(), dtype=np.int32), sizes)


def creature(n_vertices: int) -> Mesh:
    """The fox cub of the samples, in quads, with about ``n_vertices``."""
    positions, corners, _ = creature_arrays(n_vertices)
    return make_mesh(f"creature {short_count(len(positions))}", positions, corners.reshape(-1, 4))


def load_off(path: Path) -> Mesh:
    """Reads an OFF file whose faces all have the same number of corners.

    Raises:
        ValueError: it is none, or its faces differ in size.
    """
    lines = (line.partition("#")[0].split() for line in path.read_text().splitlines())
    rows = [line for line in lines if line]
    if not rows or rows[0][0] != "OFF":
        raise ValueError(f"{path}: not an OFF file, its first word must be OFF")
    n_vertices, n_faces = (int(word) for word in rows[1][:2])
    if len(rows) < 2 + n_vertices + n_faces or n_vertices == 0 or n_faces == 0:
        raise ValueError(f"{path}: {len(rows) - 2} lines for {n_vertices} vertices and {n_faces} faces")
    positions = np.array([row[:3] for row in rows[2 : 2 + n_vertices]], dtype=np.float64)
    face_rows = rows[2 + n_vertices : 2 + n_vertices + n_faces]
    size = int(face_rows[0][0])
    if any(row[0] != face_rows[0][0] for row in face_rows):
        raise ValueError(f"{path}: faces have different numbers of corners; triangulate the mesh first")
    return make_mesh(path.stem, positions, np.array([row[1 : 1 + size] for row in face_rows], dtype=np.int32))


def triangulated(mesh: Mesh) -> Mesh:
    """The mesh with each quad cut from its first to its third corner."""
    if np.all(mesh.face_sizes == 3):
        return mesh
    if not np.all(mesh.face_sizes == 4):
        raise ValueError(f"{mesh.name}: only triangles and quads can be triangulated here")
    return unscaled(mesh.name, mesh.positions, cut_quads(mesh.corner_vertices.reshape(-1, 4)))


def cut_quads(quads: Ints) -> Ints:
    """Each in two triangles from its first corner, (2 f, 3) int32."""
    return quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3).astype(np.int32)


def midpoint_subdivision(mesh: Mesh) -> Mesh:
    """Each triangle in four by its edges' midpoints, which come after the old vertices; nothing moves."""
    triangles = mesh.triangles
    ends, edge_of = _edges(mesh)
    middle = (len(mesh.positions) + edge_of).astype(np.int32)
    midpoints = mesh.positions[ends].mean(axis=1)
    at_corner = np.stack([triangles, middle, np.roll(middle, 1, axis=1)], axis=-1)
    finer = np.concatenate([at_corner, middle[:, None]], axis=1).reshape(-1, 3)
    return unscaled(f"{mesh.name}, subdivided", np.concatenate([mesh.positions, midpoints]), finer)


def midpoint_ends(mesh: Mesh) -> Ints:
    """(e, 2) int32, the vertices between which each new vertex of ``midpoint_subdivision`` is, in their order."""
    return _edges(mesh)[0]


def _edges(mesh: Mesh) -> tuple[Ints, Ints]:
    """The edges' vertices (e, 2), and of each triangle's sides (f, 3) which edge it is; side k goes from corner k."""
    n = len(mesh.positions)
    ends = np.stack([mesh.triangles, np.roll(mesh.triangles, -1, axis=1)], axis=-1)
    keys = ends.min(axis=-1).astype(np.int64) * n + ends.max(axis=-1)
    edges, edge_of = np.unique(keys, return_inverse=True)
    return np.stack([edges // n, edges % n], axis=1).astype(np.int32), edge_of.reshape(keys.shape)


def named_meshes() -> Iterator[Mesh]:
    """The meshes that ARAP_BENCH_MESHES names."""
    return map(load_off, mesh_files(os.environ.get("ARAP_BENCH_MESHES", "")))


def mesh_files(setting: str) -> list[Path]:
    """The OFF files that a setting like ARAP_BENCH_MESHES names: files and folders of them, separated by colons.

    Raises:
        ValueError: an entry is neither.
    """
    found: list[Path] = []
    for entry in filter(None, setting.split(":")):
        path = Path(entry)
        if path.is_dir():
            found += sorted(path.glob("*.off"))
        elif path.is_file():
            found.append(path)
        else:
            raise ValueError(f"ARAP_BENCH_MESHES: {entry} is no file and no folder")
    return found


def short_count(n: int) -> str:
    """A count for people: 998, 12k, 1.0M."""
    if n < 1000:
        return str(n)
    return f"{n / 1000:.0f}k" if n < 999_500 else f"{n / 1e6:.1f}M"
