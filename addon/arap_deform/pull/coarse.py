# SPDX-License-Identifier: GPL-3.0-or-later
"""A surface as a few thousand points: distances on it take hundredths of a second, however fine the mesh is. No bpy."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Floats, Ints
from ..core.distance import distances_within
from ..core.graph import connected_labels, fans
from ..core.loose.binding import bind_loose_parts
from ..core.loose.pieces import numbered

MOST_KNOWN = 50  # pieces
N_POINTS = 4000  # about as many: a finger of a figure still has some around it


@dataclass(frozen=True)
class RestMesh:
    """A mesh at rest.

    Attributes:
        points: (n, 3) as seen, so that the same grabs always hold the same vertices.
        edges: (e, 2).
        corner_vertices, face_sizes: (c,) and (f,), of the faces.
    """

    points: Floats
    edges: Ints
    corner_vertices: Ints
    face_sizes: Ints
    _known_along: dict[bytes, NDArray[np.int64]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def is_same_as(self, other: RestMesh) -> bool:
        """To compare takes a hundredth of the time that ``coarse`` takes."""
        pairs = (
            (self.points, other.points),
            (self.edges, other.edges),
            (self.corner_vertices, other.corner_vertices),
            (self.face_sizes, other.face_sizes),
        )
        return all(np.array_equal(one, another) for one, another in pairs)

    @cached_property
    def coarse(self) -> SimplifiedSurface:
        return SimplifiedSurface.of(self)

    @cached_property
    def pieces(self) -> NDArray[np.int64]:
        """(n,) numbers of the connected pieces, -1 for vertices in no face."""
        is_in_face = np.zeros(len(self.points), dtype=bool)
        is_in_face[self.corner_vertices] = True
        return numbered(connected_labels(len(self.points), *self.edges.T), is_in_face)

    def going_along(self, vertices: Ints) -> NDArray[np.int64]:
        """Vertices of the loose pieces that follow the pieces of these, see loose.search. The last ones are kept."""
        held = np.unique(self.pieces[vertices])
        if held.tobytes() not in self._known_along:
            is_held = np.zeros(int(self.pieces.max(initial=-1)) + 1, dtype=bool)
            is_held[held[held >= 0]] = True
            loose = bind_loose_parts(self.points, self.corner_vertices, self.face_sizes, self.pieces, is_held)
            self._known_along.clear()
            self._known_along[held.tobytes()] = np.empty(0, dtype=np.int64) if loose is None else loose.vertices
        return self._known_along[held.tobytes()]


@dataclass(frozen=True)
class SimplifiedSurface:
    """Neighbouring vertices drawn together to their mean. They never reach across a gap.

    Attributes:
        points: (m, 3).
        triangles, areas: (t, 3) of these points, and (t,).
        edges: (e, 2) of these points, each once.
        point_of: (n,) the point of each vertex of the mesh.
        known: the last distances, by the bytes of their sources: a drag asks several times.
    """

    points: Floats
    triangles: Ints
    areas: Floats
    edges: Ints
    point_of: NDArray[np.int64]
    known: dict[bytes, Floats] = field(default_factory=dict)

    @classmethod
    def of(cls, fine: RestMesh) -> SimplifiedSurface:
        starts = np.cumsum(fine.face_sizes, dtype=np.int64) - fine.face_sizes
        triangles = fans(fine.corner_vertices, starts, fine.face_sizes)
        sides = fine.points[fine.edges[:, 0]] - fine.points[fine.edges[:, 1]]
        cell = float(np.sqrt(np.einsum("ij,ij->", sides, sides) / 3.0 / N_POINTS))  # about the root of a point's area
        is_large = len(fine.points) > N_POINTS and cell > 0.0
        point_of = _pieces_in_cells(fine, cell) if is_large else np.arange(len(fine.points))
        sums = [np.bincount(point_of, coordinates) for coordinates in fine.points.T]
        points = np.column_stack(sums) / np.bincount(point_of)[:, None]
        triangles = _distinct(point_of[triangles])
        return cls(points, triangles, _areas(points, triangles), _distinct(point_of[fine.edges]), point_of)

    def distances(self, vertices: Ints) -> Floats:
        """(m,) along the surface, from the points of these vertices of the mesh; infinite in other pieces."""
        sources = np.unique(self.point_of[vertices]).astype(np.int32)
        found = self.known.get(sources.tobytes())
        if found is None:
            while len(self.known) >= MOST_KNOWN:
                del self.known[next(iter(self.known))]
            found = self.known[sources.tobytes()] = self._distances_from(sources)
        return found

    def _distances_from(self, sources: Ints) -> Floats:
        sizes = np.full(len(self.triangles), 3, dtype=np.int32)
        far = 1000.0 * float(np.linalg.norm(np.ptp(self.points, axis=0)))  # further than any way
        return distances_within(self.points, self.triangles.ravel(), sizes, sources, far)


def _pieces_in_cells(fine: RestMesh, cell: float) -> NDArray[np.int64]:
    """(n,) numbers of the connected pieces of the mesh within the cells of a grid."""
    cells = np.floor((fine.points - fine.points.min(axis=0)) / cell)
    inside = fine.edges[(cells[fine.edges[:, 0]] == cells[fine.edges[:, 1]]).all(axis=1)]
    labels = connected_labels(len(fine.points), *inside.T)
    return np.asarray(np.unique(labels, return_inverse=True)[1])


def _distinct(items: NDArray[np.integer]) -> Ints:
    """Edges or triangles whose corners differ, each once."""
    items = items[(items != np.roll(items, 1, axis=1)).all(axis=1)]
    return np.asarray(np.unique(np.sort(items, axis=1), axis=0), dtype=np.int32)


def _areas(points: Floats, triangles: Ints) -> Floats:
    one, two, three = (points[triangles[:, i]] for i in range(3))
    return np.asarray(0.5 * np.linalg.norm(np.cross(two - one, three - one), axis=1))
