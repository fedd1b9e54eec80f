# SPDX-License-Identifier: GPL-3.0-or-later
"""A closed quad mesh in numpy, with all that is carried along when it is made finer."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

FLIP_X = np.array([-1.0, 1.0, 1.0])


@dataclass
class QuadMesh:
    """A closed quad mesh.

    Attributes:
        positions: (n, 3) float64.
        quads: (f, 4) int32, counter-clockwise seen from outside.
        mirror: (n,) int32, the partner of each vertex under x -> -x, itself on the plane; None without symmetry.
        vertex_data: values per vertex that are smoothed like positions, each (n, k) float64.
        face_data: values per face that children inherit, each (f,) int32.
        paths: chains of vertices along edges, each (k,) int32.
    """

    positions: Floats
    quads: Ints
    mirror: Ints | None = None
    vertex_data: dict[str, Floats] = field(default_factory=dict)
    face_data: dict[str, Ints] = field(default_factory=dict)
    paths: dict[str, Ints] = field(default_factory=dict)


def edges_of(quads: Ints) -> tuple[Ints, Ints]:
    """Edges (e, 2), smaller vertex first, and the edge of each face side (f, 4); side k joins corners k and k + 1."""
    sides = np.stack([quads, np.roll(quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    edges, inverse = np.unique(np.sort(sides, axis=1), axis=0, return_inverse=True)
    return edges.astype(np.int32), inverse.reshape(quads.shape).astype(np.int32)


def symmetrized(positions: Floats, mirror: Ints | None) -> Floats:
    """The positions with both halves equal to the last bit, which rounding in sums does not give."""
    if mirror is None:
        return positions
    return np.asarray(0.5 * (positions + positions[mirror] * FLIP_X))


def vertex_normals(mesh: QuadMesh) -> Floats:
    """(n, 3) unit normals, as symmetric as the mesh."""
    corners = mesh.positions[mesh.quads]
    face_normals = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    sums = np.zeros_like(mesh.positions)
    np.add.at(sums, mesh.quads.ravel(), np.repeat(face_normals, 4, axis=0))
    sums = symmetrized(sums, mesh.mirror)
    return np.asarray(sums / np.linalg.norm(sums, axis=1)[:, None])


def find_rows(wanted: Ints, rows: Ints) -> Ints:
    """Where each row of ``wanted`` stands in ``rows``; both hold the same set of rows.

    Raises:
        ValueError: they do not.
    """
    order, sought = np.lexsort(rows.T), np.lexsort(wanted.T)
    if not np.array_equal(rows[order], wanted[sought]):
        raise ValueError("the mesh's topology is not its own mirror image; check the mirror partners")
    place = np.empty(len(rows), dtype=np.int32)
    place[sought] = order
    return place


def mirrored_edges(mesh: QuadMesh, edges: Ints) -> Ints:
    """(e,) int32, the partner of each edge: it joins the partners of its ends."""
    assert mesh.mirror is not None
    return find_rows(np.sort(mesh.mirror[edges], axis=1), edges)


def mirrored_faces(side_edge: Ints, edge_mirror: Ints) -> Ints:
    """(f,) int32, the partner of each face: it has the partners of its sides."""
    return find_rows(np.sort(edge_mirror[side_edge], axis=1), np.sort(side_edge, axis=1))
