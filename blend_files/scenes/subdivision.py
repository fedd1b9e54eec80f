# SPDX-License-Identifier: GPL-3.0-or-later
"""Smooth subdivision of closed quad meshes, by two (Catmull-Clark) and by three."""

from __future__ import annotations

import numpy as np

from .quad_mesh import Floats, Ints, QuadMesh, edges_of, mirrored_edges, mirrored_faces, symmetrized


def catmull_clark(mesh: QuadMesh) -> QuadMesh:
    """One level: n + e + f vertices (old ones first, then one an edge, then one a face) and 4 f quads."""
    n, n_faces = len(mesh.positions), len(mesh.quads)
    edges, side_edge = edges_of(mesh.quads)
    n_edges = len(edges)

    edge_point = n + side_edge
    face_point = np.repeat(np.arange(n_faces, dtype=np.int32)[:, None] + n + n_edges, 4, axis=1)
    quads = np.stack([mesh.quads, edge_point, face_point, np.roll(edge_point, 1, axis=1)], axis=-1)

    mirror = None
    if mesh.mirror is not None:
        edge_mirror = mirrored_edges(mesh, edges)
        face_mirror = mirrored_faces(side_edge, edge_mirror)
        mirror = np.concatenate([mesh.mirror, n + edge_mirror, n + n_edges + face_mirror]).astype(np.int32)

    def smooth(values: Floats) -> Floats:
        return _catmull_clark_rule(values, mesh.quads, edges, side_edge)

    return QuadMesh(
        positions=symmetrized(smooth(mesh.positions), mirror),
        quads=quads.reshape(-1, 4).astype(np.int32),
        mirror=mirror,
        vertex_data={name: smooth(data) for name, data in mesh.vertex_data.items()},
        face_data={name: np.repeat(data, 4) for name, data in mesh.face_data.items()},
        paths={name: _finer_path(path, edges, n) for name, path in mesh.paths.items()},
    )


def split_by_three(mesh: QuadMesh) -> QuadMesh:
    """One level of cubic B-spline subdivision by three: n + 2 e + 4 f vertices and 9 f quads; paths end here."""
    n, n_faces = len(mesh.positions), len(mesh.quads)
    edges, side_edge = edges_of(mesh.quads)
    n_edges = len(edges)

    # Two vertices an edge, the one near its first end first; four a face, one near each corner.
    near_start = n + 2 * side_edge + (edges[side_edge, 0] != mesh.quads)
    near_end = n + 2 * side_edge + (edges[side_edge, 0] == mesh.quads)
    inner = n + 2 * n_edges + np.arange(4 * n_faces, dtype=np.int32).reshape(-1, 4)
    at_corner = np.stack([mesh.quads, near_start, inner, np.roll(near_end, 1, axis=1)], axis=-1)
    at_side = np.stack([near_start, near_end, np.roll(inner, -1, axis=1), inner], axis=-1)
    quads = np.concatenate([at_corner, at_side, inner[:, None]], axis=1).reshape(-1, 4).astype(np.int32)

    mirror = None
    if mesh.mirror is not None:
        mirror = _mirror_by_three(mesh, edges, side_edge)

    def smooth(values: Floats) -> Floats:
        ends, corners = values[edges], values[mesh.quads]
        thirds = np.stack([2 * ends[:, 0] + ends[:, 1], ends[:, 0] + 2 * ends[:, 1]], axis=1) / 3
        sides = np.roll(corners, -1, axis=1) + np.roll(corners, 1, axis=1)
        insides = (4 * corners + 2 * sides + np.roll(corners, 2, axis=1)) / 9
        k = values.shape[1]
        flat = np.concatenate([values, thirds.reshape(-1, k), insides.reshape(-1, k)])
        # The mask of cubic B-splines by three is the linear one, averaged twice over three neighbours.
        return _average(_average(flat, quads), quads)

    return QuadMesh(
        positions=symmetrized(smooth(mesh.positions), mirror),
        quads=quads,
        mirror=mirror,
        vertex_data={name: smooth(data) for name, data in mesh.vertex_data.items()},
        face_data={name: np.repeat(data, 9) for name, data in mesh.face_data.items()},
    )


def _catmull_clark_rule(values: Floats, quads: Ints, edges: Ints, side_edge: Ints) -> Floats:
    """(n + e + f, k) from (n, k)."""
    n = len(values)
    face_points = values[quads].mean(axis=1)
    middles = values[edges].mean(axis=1)
    around_edge = _mean(side_edge, face_points, len(edges))
    around_vertex = _mean(quads, face_points, n)
    middle_vertex = _mean(edges, middles, n)
    valence = np.bincount(edges.ravel(), minlength=n)[:, None]
    old = (around_vertex + 2.0 * middle_vertex + (valence - 3.0) * values) / valence
    return np.concatenate([old, 0.5 * (middles + around_edge), face_points])


def _average(values: Floats, quads: Ints) -> Floats:
    """Each vertex as the mean of itself, its neighbours and the far corners of its faces, all at the same weight."""
    n = len(values)
    valence = np.bincount(quads.ravel(), minlength=n)[:, None]
    corners = values[quads]
    # A neighbour is in two of the vertex's faces, a far corner in one.
    around = 0.5 * (np.roll(corners, 1, axis=1) + np.roll(corners, -1, axis=1)) + np.roll(corners, 2, axis=1)
    return np.asarray((values + _sum(quads, around, n)) / (1 + 2 * valence))


def _mean(index: Ints, values: Floats, n: int) -> Floats:
    """Mean over the rows of ``index`` (m, c) that hold each of n entries, of the rows' values (m, k)."""
    count = np.bincount(index.ravel(), minlength=n)[:, None]
    return _sum(index, np.repeat(values[:, None], index.shape[1], axis=1), n) / count


def _sum(index: Ints, values: Floats, n: int) -> Floats:
    """Sums (n, k) of values (m, c, k) at index (m, c)."""
    flat = values.reshape(-1, values.shape[-1])
    sums = [np.bincount(index.ravel(), weights=flat[:, k], minlength=n) for k in range(flat.shape[1])]
    return np.stack(sums, axis=-1)


def _mirror_by_three(mesh: QuadMesh, edges: Ints, side_edge: Ints) -> Ints:
    assert mesh.mirror is not None
    n, n_edges = len(mesh.positions), len(edges)
    edge_mirror = mirrored_edges(mesh, edges)
    is_reversed = edges[edge_mirror, 0] != mesh.mirror[edges[:, 0]]
    ends = np.stack([2 * edge_mirror + is_reversed, 2 * edge_mirror + ~is_reversed], axis=1)
    face_mirror = mirrored_faces(side_edge, edge_mirror)
    partners = mesh.quads[face_mirror]
    corner = np.argmax(partners[:, None, :] == mesh.mirror[mesh.quads][:, :, None], axis=2)
    inner = n + 2 * n_edges + 4 * face_mirror[:, None] + corner
    return np.asarray(np.concatenate([mesh.mirror, n + ends.ravel(), inner.ravel()]), dtype=np.int32)


def _finer_path(path: Ints, edges: Ints, n: int) -> Ints:
    """The same chain one level on: the old vertices and, between them, their edges' vertices."""
    steps = np.sort(np.stack([path[:-1], path[1:]], axis=1), axis=1)
    keys = edges[:, 0].astype(np.int64) * n + edges[:, 1]
    finer = np.empty(2 * len(path) - 1, dtype=np.int32)
    finer[0::2] = path
    finer[1::2] = n + np.searchsorted(keys, steps[:, 0].astype(np.int64) * n + steps[:, 1])
    return finer
