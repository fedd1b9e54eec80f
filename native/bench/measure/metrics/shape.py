# SPDX-License-Identifier: GPL-3.0-or-later
"""How good a deformed surface looks, in numbers: changed dihedral angles and curvature, flipped faces, thickness."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..inputs.mesh import Floats, Ints, Mask, Mesh

SHARP_RAD = np.pi / 3


class Change(NamedTuple):
    """What a deformation did to a region of a surface.

    Attributes:
        curvature: integral |dH| dA, H the mean curvature; in units of length.
        max_deg: the largest change of an edge's dihedral angle.
        rms_deg: the root of the mean square of these changes.
        sharp_edges: edges whose dihedral angle changed by more than 60 degrees.
        flips: faces whose normal is against their rotated rest normal.
    """

    curvature: float
    max_deg: float
    rms_deg: float
    sharp_edges: int
    flips: int


class Surface:
    """A mesh of triangles at rest, prepared to measure deformations of it."""

    def __init__(self, mesh: Mesh) -> None:
        self._rest = mesh.positions
        self._triangles = mesh.triangles
        self.edges, self._faces = interior_edges(mesh.triangles)
        self._angles = dihedral_angles(self._rest, self._triangles, self.edges, self._faces)

    def bends(self, positions: Floats) -> Floats:
        """(e,) changes of the edges' dihedral angles, radians in (-pi, pi]."""
        change = dihedral_angles(positions, self._triangles, self.edges, self._faces) - self._angles
        return np.asarray(np.pi - (np.pi - change) % (2 * np.pi))

    def change(self, positions: Floats, region: Mask) -> Change:
        """What became of the vertices of ``region``, and of the edges and faces that lie wholly in it."""
        bends = np.degrees(np.abs(self.bends(positions)[np.all(region[self.edges], axis=1)]))
        before, after = (self._integrated_curvature(p) for p in (self._rest, positions))
        return Change(
            curvature=float(np.abs(after - before)[region].sum()),
            max_deg=float(bends.max(initial=0.0)),
            rms_deg=float(np.sqrt(np.mean(bends**2))) if len(bends) else 0.0,
            sharp_edges=int(np.count_nonzero(bends > np.degrees(SHARP_RAD))),
            flips=int(np.count_nonzero(self.flipped(positions, np.all(region[self._triangles], axis=1)))),
        )

    def flipped(self, positions: Floats, faces: Mask) -> Mask:
        """Which of the chosen faces point against their rest normal, turned as the faces that touch them are."""
        chosen = self._triangles[faces]
        covariances = self._covariances(positions)[chosen].sum(axis=1)
        turned = np.einsum("fij,fj->fi", rotations(covariances), normals(self._rest, chosen))
        return np.asarray(np.einsum("fi,fi->f", turned, normals(positions, chosen)) < 0.0)

    def _covariances(self, positions: Floats) -> Floats:
        """(n, 3, 3) sums over the edges at each vertex of deformed edge times rest edge."""
        rest, now = (p[self.edges[:, 0]] - p[self.edges[:, 1]] for p in (self._rest, positions))
        products = (now[:, :, None] * rest[:, None, :]).reshape(-1, 9)
        return _sums_at_ends(self.edges, products, len(positions)).reshape(-1, 3, 3)

    def _integrated_curvature(self, positions: Floats) -> Floats:
        """(n,) integral of H around each vertex: half of each edge's, which is angle times length / 2."""
        angles = dihedral_angles(positions, self._triangles, self.edges, self._faces)
        lengths = np.linalg.norm(positions[self.edges[:, 0]] - positions[self.edges[:, 1]], axis=1)
        return _sums_at_ends(self.edges, (0.25 * angles * lengths)[:, None], len(positions))[:, 0]


def largest_distance(a: NDArray[np.floating], b: NDArray[np.floating]) -> float:
    """Between rows (k, 3) of the same number."""
    return float(np.linalg.norm(a - b, axis=1).max())


def interior_edges(triangles: Ints) -> tuple[Ints, Ints]:
    """The edges (e, 2) that have exactly two faces, as directed in the first of these, and their faces (e, 2)."""
    ends = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)
    keys = ends.min(axis=1).astype(np.int64) * (int(triangles.max()) + 1) + ends.max(axis=1)
    order = np.argsort(keys, kind="stable")
    _, first, counts = np.unique(keys[order], return_index=True, return_counts=True)
    sides = order[first[counts == 2][:, None] + np.arange(2)]
    return ends[sides[:, 0]], (sides // 3).astype(np.int32)


def dihedral_angles(positions: Floats, triangles: Ints, edges: Ints, faces: Ints) -> Floats:
    """(e,) angles between the normals of the edges' faces: radians, 0 where flat, positive where convex."""
    unit = normals(positions, triangles)
    first, second = unit[faces[:, 0]], unit[faces[:, 1]]
    along = positions[edges[:, 1]] - positions[edges[:, 0]]
    along /= np.maximum(np.linalg.norm(along, axis=1), np.finfo(float).tiny)[:, None]
    sines = np.einsum("ei,ei->e", np.cross(first, second), along)
    return np.asarray(np.arctan2(sines, np.einsum("ei,ei->e", first, second)))


def normals(positions: Floats, triangles: Ints) -> Floats:
    """(f, 3) unit normals; 0 where a face has no area."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    cross = np.cross(b - a, c - a)
    return np.asarray(cross / np.maximum(np.linalg.norm(cross, axis=1), np.finfo(float).tiny)[:, None])


def rotations(covariances: Floats) -> Floats:
    """(m, 3, 3) rotations nearest to matrices, [SA07] Eq. (6)."""
    u, _, vt = np.linalg.svd(covariances)
    u[:, :, 2] *= np.where(np.linalg.det(u @ vt) < 0.0, -1.0, 1.0)[:, None]
    return np.asarray(u @ vt)


def facing(positions: Floats, axis: int) -> tuple[Ints, Ints]:
    """Vertices (k,) of the two outermost planes across an axis of a plate, those that lie opposite side by side."""
    across = positions[:, axis]
    sides = [np.flatnonzero(np.abs(across - end) < 1e-9) for end in (across.max(), across.min())]
    along = np.delete(np.rint(positions * 1e7), axis, axis=1)
    front, back = (side[np.lexsort(along[side].T)].astype(np.int32) for side in sides)
    return front, back


def thickness(mesh: Mesh, front: Ints, back: Ints, positions: Floats) -> Floats:
    """(k,) distance from back to front along the front's normal, over that at rest; negative where they passed.

    Args:
        mesh: at rest.
        front, back: (k,) vertices that face each other.
        positions: (n, 3) deformed.
    """
    heights = []
    for p in (mesh.positions, positions):
        along = normals(p, mesh.triangles)
        sums = np.zeros_like(p)
        for k in range(3):
            for i in range(3):
                sums[:, i] += np.bincount(mesh.triangles[:, k], along[:, i], len(p))
        unit = sums[front] / np.maximum(np.linalg.norm(sums[front], axis=1), np.finfo(float).tiny)[:, None]
        heights.append(np.einsum("ki,ki->k", p[front] - p[back], unit))
    return np.asarray(heights[1] / heights[0])


def _sums_at_ends(edges: Ints, values: Floats, n: int) -> Floats:
    """(n, k) sums of the edges' values (e, k) over the edges at each vertex."""
    columns = [sum(np.bincount(edges[:, end], column, n) for end in range(2)) for column in values.T]
    return np.stack(columns, axis=-1)
