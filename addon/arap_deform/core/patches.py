# SPDX-License-Identifier: GPL-3.0-or-later
"""Point handles: which handles are too small to hold vertices, and how far their patches may reach.

A handle that is smaller than the rigidity radius would pull a spike out of a dense mesh if it held its vertices. So it
holds the weighted average of a round patch around them. The mesh then rises in a smooth hill, alike at every density.

"Seen" means solver space: object space times the stretch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats, Ints
from .graph import connected_labels, face_edges
from .targets import HandleSpec, Patch

if TYPE_CHECKING:
    import arap_native

FoundPatch: TypeAlias = tuple[Ints, Floats, Floats]
"""Vertices, weights and the average of their rest positions, in solver space."""

PATCH_REACH = 1.5  # how far a patch reaches beyond the handle's vertices, in rigidity radii


@dataclass(frozen=True)
class Ball:
    """A ball around vertices, as seen."""

    centre: Floats
    radius: float

    @classmethod
    def about(cls, points: Floats) -> Ball:
        centre = points.mean(axis=0)
        return cls(centre, float(np.linalg.norm(points - centre, axis=1).max()))


@dataclass(frozen=True)
class Surface:
    """What tells which handles are points; no bind is needed for it.

    Attributes:
        seen: (n, 3) the mesh at rest.
        corner_vertices, face_sizes: its faces.
        radius: the rigidity radius.
    """

    seen: Floats
    corner_vertices: Ints
    face_sizes: Ints
    radius: float

    @cached_property
    def has_face(self) -> NDArray[np.bool_]:
        """(n,) which vertices are in a face."""
        result = np.zeros(len(self.seen), dtype=bool)
        result[self.corner_vertices] = True
        return result

    @classmethod
    def of(cls, seen: Floats, corner_vertices: Ints, face_sizes: Ints, rigidity_radius: float) -> Surface:
        """``rigidity_radius``: a fraction of the diagonal."""
        radius = rigidity_radius * surface_diagonal(seen, corner_vertices)
        return cls(seen, corner_vertices, face_sizes, radius)


@dataclass(frozen=True)
class Point:
    """A handle, or a piece of one, that is too small to hold its vertices.

    Attributes:
        handle: its index.
        vertices: (k,) of the piece.
        reach: how far its patch reaches beyond them, as seen.
    """

    handle: int
    vertices: Ints
    reach: float


def points_of(specs: Sequence[HandleSpec], surface: Surface) -> list[Point]:
    """The point handles among all handles and pins, in their order.

    A point handle is hard, is not exact, and has its vertices within the radius of their centre. Its patch ends before
    the vertices that another handle or pin holds hard, so no vertex is pulled to two places. A handle with vertices of
    another one inside it is no point handle. In a larger handle each connected piece that is as small, and farther
    than the radius from all else that is held, is a point of its own.
    """
    radius = surface.radius
    small: list[_Piece] = []
    large: list[_Piece] = []
    for i, spec in enumerate(specs):
        vertices = spec.vertices
        is_candidate = not spec.use_exact and len(vertices) and spec.weights.min() >= 1.0
        if is_candidate and surface.has_face[vertices].all():
            ball = Ball.about(surface.seen[vertices])
            (small if ball.radius < radius else large).append(_Piece(i, vertices, ball, least_reach=0.0))
    pieces = [*small, *_small_pieces(large, surface)]
    held = _Held(specs, pieces, surface)
    points = []
    for number, piece in enumerate(pieces):
        reach = min(PATCH_REACH * radius, held.nearest_to(piece.ball.centre, number) - piece.ball.radius)
        reach = specs[piece.handle].reach * radius or reach
        if reach > piece.least_reach:
            points.append(Point(piece.handle, piece.vertices, reach))
    return sorted(points, key=lambda point: point.handle)


@dataclass(frozen=True)
class _Piece:
    """What may be a point: see Point. ``least_reach``: with less it is none."""

    handle: int
    vertices: Ints
    ball: Ball
    least_reach: float


def _small_pieces(handles: Sequence[_Piece], surface: Surface) -> list[_Piece]:
    """The connected pieces of these handles that are smaller than the radius. Handles of one piece have none."""
    if not handles:
        return []
    is_inside = np.zeros(len(surface.seen), dtype=bool)
    for handle in handles:
        is_inside[handle.vertices] = True
    sides = np.stack(face_edges(surface.corner_vertices, surface.face_sizes))
    sides = sides[:, is_inside[sides].all(axis=0)]
    local = np.full(len(surface.seen), -1, dtype=np.int64)
    pieces = []
    for handle in handles:
        vertices = handle.vertices
        local[vertices] = np.arange(len(vertices))
        first, second = local[sides]
        is_own = (first >= 0) & (second >= 0)
        labels = connected_labels(len(vertices), first[is_own], second[is_own])
        local[vertices] = -1
        order = np.argsort(labels, kind="stable")
        for piece in np.split(vertices[order], np.flatnonzero(np.diff(labels[order])) + 1):
            ball = Ball.about(surface.seen[piece])
            if ball.radius < surface.radius:
                pieces.append(_Piece(handle.handle, piece, ball, least_reach=surface.radius))
    return pieces


class _Held:
    """The vertices that handles and pins hold hard, in cells, to find those near a place."""

    def __init__(self, specs: Sequence[HandleSpec], pieces: Sequence[_Piece], surface: Surface) -> None:
        """``pieces``: the vertices of a piece are not found near the piece itself."""
        # A piece in a ball of the radius looks as far as its patch may reach from there.
        self._cell = (1.0 + PATCH_REACH) * surface.radius or 1.0
        vertices: list[Ints] = [np.empty(0, dtype=np.int32)]
        owners: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
        of_handle: dict[int, list[int]] = {}
        for number, piece in enumerate(pieces):
            of_handle.setdefault(piece.handle, []).append(number)
        owner_of = np.full(len(surface.seen), -1, dtype=np.int64)
        for i, spec in enumerate(specs):
            hard = spec.vertices[spec.weights >= 1.0]
            for number in of_handle.get(i, ()):
                owner_of[pieces[number].vertices] = number
            vertices.append(hard)
            owners.append(owner_of[hard])
            owner_of[hard] = -1
        self._points = surface.seen[np.concatenate(vertices)]
        self._owners = np.concatenate(owners)
        keys = self._keys(np.floor(self._points / self._cell).astype(np.int64))
        self._order = np.argsort(keys, kind="stable")
        self._sorted = keys[self._order]

    def nearest_to(self, centre: Floats, number: int) -> float:
        """Distance of the nearest vertex that the piece of that number does not hold; infinite beyond a cell."""
        cells = np.floor(centre / self._cell).astype(np.int64) + _AROUND
        keys = np.unique(self._keys(cells))
        starts, ends = np.searchsorted(self._sorted, keys), np.searchsorted(self._sorted, keys, side="right")
        near = np.concatenate([self._order[a:b] for a, b in zip(starts, ends, strict=True)])
        near = near[self._owners[near] != number]
        distances = np.linalg.norm(self._points[near] - centre, axis=1)
        return float(distances.min(initial=np.inf))

    @staticmethod
    def _keys(cells: NDArray[np.int64]) -> NDArray[np.int64]:
        """A number for each cell; distant cells may share one."""
        return np.asarray(cells @ np.array([73856093, 19349663, 83492791]))


_AROUND = np.stack(np.meshgrid(*[np.arange(-1, 2)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)


def begin_patches(model: Any, groups: Sequence[Ints], reaches: Sequence[float]) -> arap_native.Job[list[FoundPatch]]:
    """Begins to find the patches of points, for patches_from().

    Args:
        model: an arap_native.SurfaceArap of the mesh, in solver space.
        groups: the vertices of each point, each in a face.
        reaches: a fraction of the diagonal for each.
    """
    around = [np.ascontiguousarray(vertices, dtype=np.int32) for vertices in groups]
    job: arap_native.Job[list[FoundPatch]] = model.begin_patches(around, np.array(reaches, dtype=np.float64))
    return job


def patches_from(found: Sequence[FoundPatch], groups: Sequence[Ints], unstretch: Floats) -> list[Patch | None]:
    """The patch of each point, None if no other vertex is within its reach.

    Args:
        found: result of begin_patches().
        groups: as there.
        unstretch: (3, 3), from what is seen to object space.
    """
    return [
        Patch(vertices, weights, unstretch @ centre, group) if len(vertices) > len(group) else None
        for (vertices, weights, centre), group in zip(found, groups, strict=True)
    ]


def held_by_themselves(
    specs: Sequence[HandleSpec], of_points: Mapping[int, Sequence[Ints]], n: int
) -> NDArray[np.bool_]:
    """(n,) the vertices that are held hard, each in its place.

    Args:
        specs: all handles and pins.
        of_points: the vertices of which averages are held instead, by index of the handle.
        n: vertices of the mesh.
    """
    result = np.zeros(n, dtype=bool)
    for i, spec in enumerate(specs):
        hard = spec.vertices[spec.weights >= 1.0]
        result[np.setdiff1d(hard, np.concatenate(of_points[i])) if i in of_points else hard] = True
    return result


def without_points(spec: HandleSpec, points: Sequence[Point]) -> HandleSpec:
    """The handle without the vertices of which it holds an average."""
    if not points:
        return spec
    is_left = ~np.isin(spec.vertices, np.concatenate([point.vertices for point in points]))
    return replace(spec, vertices=spec.vertices[is_left], weights=spec.weights[is_left])


def without(patch: Patch, is_held: NDArray[np.bool_]) -> Patch | None:
    """The patch without these vertices. None if all others are its own.

    A patch that has kept its reach may have such vertices, see HandleSpec.reach. The others keep their weights relative
    to each other, so the force of the point on the surface stays the same.
    """
    is_left = ~is_held[patch.vertices]
    if is_left.all():
        return patch
    weights = patch.weights[is_left]
    if not weights.sum() > 0.0:
        return None
    return replace(patch, vertices=patch.vertices[is_left], weights=weights / weights.sum())


def diagonal_of(points: NDArray[np.floating]) -> float:
    """Of the bounding box of (k, 3) points."""
    # Axis by axis: numpy takes forty times as long for all three at once.
    return float(np.linalg.norm([np.ptp(points[:, axis]) for axis in range(3)]))


def surface_diagonal(points: NDArray[np.floating], corner_vertices: Ints) -> float:
    """Of the bounding box of the vertices that are in faces, which the solver's radius is a fraction of; 0 for none."""
    if len(corner_vertices) == 0:
        return 0.0
    is_in_face = np.zeros(len(points), dtype=bool)
    is_in_face[corner_vertices] = True
    return diagonal_of(points if is_in_face.all() else points[is_in_face])
