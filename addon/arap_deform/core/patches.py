# SPDX-License-Identifier: GPL-3.0-or-later
"""Point handles: which handles are too small to hold vertices, and how far their patches may reach.

A handle that is smaller than the rigidity radius would pull a spike out of a dense mesh if it held its vertices. So it
holds the weighted average of a round patch around them. The mesh then rises in a smooth hill, alike at every density.

"Seen" means solver space: object space times the stretch.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats, Ints
from .models import Model, ModelInput, begin_bind
from .session_data import SessionMesh, SessionSettings
from .targets import HandleSpec, Patch

if TYPE_CHECKING:
    import arap_native

FoundPatch: TypeAlias = tuple[Ints, Floats, Floats]
"""Vertices, weights and the average of their rest positions, in solver space."""

PATCH_REACH = 1.5  # how far a patch reaches beyond the handle's vertices, in rigidity radii


@dataclass(frozen=True)
class Ball:
    """A ball around a handle's vertices, as seen."""

    centre: Floats
    radius: float

    @classmethod
    def about(cls, points: Floats) -> Ball:
        centre = points.mean(axis=0)
        return cls(centre, float(np.linalg.norm(points - centre, axis=1).max()))


def reaches_of_points(
    specs: Sequence[HandleSpec], rest_positions: Floats, stretch: Floats, radius: float, faceless: Ints
) -> dict[int, float]:
    """How far the patch of each point handle reaches beyond its vertices, as seen, by index of the handle.

    A point handle is hard, is not exact, and has its vertices within ``radius`` of their centre. Its patch ends before
    the vertices that another handle or pin holds hard, so no vertex is pulled to two places. A handle with vertices of
    another one inside it is no point handle.

    Args:
        specs: all handles and pins.
        rest_positions: (n, 3) object space.
        stretch: (3, 3).
        radius: the rigidity radius as seen.
        faceless: vertices in no face.
    """
    balls = {}
    for i, spec in enumerate(specs):
        if spec.is_exact or not len(spec.vertices) or not (spec.weights >= 1.0).all():
            continue
        ball = Ball.about(rest_positions[spec.vertices] @ stretch.T)
        if ball.radius < radius and not np.isin(spec.vertices, faceless).any():
            balls[i] = ball
    if not balls:
        return {}
    hard = [spec.vertices[spec.weights >= 1.0] for spec in specs]
    owners = np.repeat(np.arange(len(specs)), [len(vertices) for vertices in hard])
    points = rest_positions[np.concatenate(hard)] @ stretch.T
    reaches = {}
    for i, near in _near(points, balls, PATCH_REACH * radius).items():
        others = points[near[owners[near] != i]]
        reach = PATCH_REACH * radius
        if len(others):
            nearest = float(np.linalg.norm(others - balls[i].centre, axis=1).min())
            reach = min(reach, nearest - balls[i].radius)
        if reach > 0.0:
            reaches[i] = reach
    return reaches


def _near(points: Floats, balls: Mapping[int, Ball], reach: float) -> dict[int, NDArray[np.intp]]:
    """For each ball all points within ``reach`` of it, and some others: those in its cell of a grid and around that."""
    centres = np.array([ball.centre for ball in balls.values()])
    size = reach + max(ball.radius for ball in balls.values())
    low = centres.min(axis=0) - 2.0 * size
    high = centres.max(axis=0) + 2.0 * size
    inside = np.flatnonzero(((points >= low) & (points <= high)).all(axis=1))
    columns = ((high - low) / size).astype(np.int64) + 1

    def numbers(places: Floats) -> NDArray[np.int64]:
        cell: NDArray[np.int64] = ((places - low) / size).astype(np.int64)
        number: NDArray[np.int64] = (cell[:, 0] * columns[1] + cell[:, 1]) * columns[2] + cell[:, 2]
        return number

    cells = numbers(points[inside])
    order = np.argsort(cells, kind="stable")
    cells, inside = cells[order], inside[order]
    beside = np.array([(dx * columns[1] + dy) * columns[2] for dx in (-1, 0, 1) for dy in (-1, 0, 1)])
    rows = numbers(centres)[:, None] + beside  # of three cells each
    starts, ends = np.searchsorted(cells, rows - 1), np.searchsorted(cells, rows + 1, side="right")
    return {
        i: np.concatenate([inside[a:b] for a, b in zip(*bounds, strict=True)])
        for i, *bounds in zip(balls, starts, ends, strict=True)
    }


@dataclass(frozen=True)
class Neighbourhood:
    """The faces around some vertices, as a mesh of its own.

    Attributes:
        vertices: (m,) indices in the whole mesh, ascending.
        corner_vertices, face_sizes: of these vertices, int32.
    """

    vertices: NDArray[np.int64]
    corner_vertices: Ints
    face_sizes: Ints


def neighbourhood(seen: Floats, corner_vertices: Ints, face_sizes: Ints, vertices: Ints, reach: float) -> Neighbourhood:
    """All faces with a vertex within ``reach`` of ``vertices``. A patch of that reach depends on no others.

    Args:
        seen: (n, 3) positions of the whole mesh.
    """
    ball = Ball.about(seen[vertices])
    is_near = np.linalg.norm(seen - ball.centre, axis=1) <= ball.radius + reach
    starts = np.cumsum(face_sizes, dtype=np.int64) - face_sizes
    is_face_near = np.logical_or.reduceat(is_near[corner_vertices], starts)
    corners = corner_vertices[np.repeat(is_face_near, face_sizes)]
    inside, local = np.unique(corners, return_inverse=True)
    return Neighbourhood(inside, local.astype(np.int32), face_sizes[is_face_near].astype(np.int32))


def begin_patches(model: Model, groups: Sequence[Ints], reaches: Sequence[float]) -> arap_native.Job[list[FoundPatch]]:
    """Begins to find the patches of point handles, for patches_from().

    Args:
        model: of the mesh, in solver space.
        groups: the vertices of each handle, each in a face.
        reaches: a fraction of the diagonal for each.
    """
    around = [np.ascontiguousarray(vertices, dtype=np.int32) for vertices in groups]
    return model.begin_patches(around, np.array(reaches, dtype=np.float64))


def patches_from(found: Sequence[FoundPatch], groups: Sequence[Ints], unstretch: Floats) -> list[Patch | None]:
    """The patch of each point handle, None if no other vertex is within its reach.

    Args:
        found: result of begin_patches().
        groups: as there.
        unstretch: (3, 3), from what is seen to object space.
    """
    return [
        Patch(vertices, weights, unstretch @ centre) if len(vertices) > len(group) else None
        for (vertices, weights, centre), group in zip(found, groups, strict=True)
    ]


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


def local_patch(
    native: Any,
    rest_positions: Floats,
    part: Neighbourhood,
    vertices: Ints,
    reach: float,
    stretch: Floats,
    settings: SessionSettings,
) -> Patch | None:
    """As begin_patches(), without a model of the whole mesh.

    Args:
        native: the module arap_native.
        rest_positions: (n, 3) of the whole mesh, object space.
        part: neighbourhood() of the vertices.
        vertices: (k,) of the handle, each in a face.
        reach: as seen.
        stretch: (3, 3).
        settings: as the whole mesh is bound.
    """
    seen = SessionMesh(rest_positions[part.vertices] @ stretch.T, part.corner_vertices, part.face_sizes)
    # The patch is the same with every energy, and this one is bound the fastest.
    model = begin_bind(native, ModelInput(seen, replace(settings, energy="spokes_and_rims", threads=1))).result()
    local = np.searchsorted(part.vertices, vertices).astype(np.int32)
    unstretch = np.asarray(np.linalg.inv(stretch), dtype=np.float64)
    job = begin_patches(model, [local], [reach / diagonal_of(seen.rest_positions)])
    (patch,) = patches_from(job.result(), [local], unstretch)
    return None if patch is None else replace(patch, vertices=part.vertices[patch.vertices].astype(np.int32))
