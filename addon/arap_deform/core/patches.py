# SPDX-License-Identifier: GPL-3.0-or-later
"""Point handles: which handles are too small to hold vertices, and how far their patches may reach.

A handle that is smaller than the rigidity radius would pull a spike out of a dense mesh if it held its vertices. So it
holds the weighted average of a round patch around them. The mesh then rises in a smooth hill, alike at every density.

"Seen" means solver space: object space times the stretch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats, Ints
from .models import Model, ModelInput, make
from .session_data import SessionMesh, SessionSettings
from .targets import HandleSpec, Patch

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
    seen = [rest_positions[spec.vertices] @ stretch.T for spec in specs]
    hard = [points[spec.weights >= 1.0] for spec, points in zip(specs, seen, strict=True)]
    reaches = {}
    for i, spec in enumerate(specs):
        if spec.is_exact or not len(spec.vertices) or len(hard[i]) < len(spec.vertices):
            continue
        ball = Ball.about(seen[i])
        if ball.radius >= radius or np.isin(spec.vertices, faceless).any():
            continue
        reach = PATCH_REACH * radius
        for points in hard[:i] + hard[i + 1 :]:
            if len(points):
                nearest = float(np.linalg.norm(points - ball.centre, axis=1).min())
                reach = min(reach, nearest - ball.radius)
        if reach > 0.0:
            reaches[i] = reach
    return reaches


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


def patch_around(model: Model, vertices: Ints, reach: float, unstretch: Floats) -> Patch | None:
    """The patch of a point handle, None if no other vertex is within ``reach``.

    Args:
        model: of the mesh, in solver space.
        vertices: (k,) of the handle, each in a face.
        reach: a fraction of the diagonal.
        unstretch: (3, 3), from what is seen to object space.
    """
    found, weights, centre = model.patch_around(np.ascontiguousarray(vertices, dtype=np.int32), reach)
    return Patch(found, weights, unstretch @ centre) if len(found) > len(vertices) else None


def diagonal_of(points: NDArray[np.floating]) -> float:
    """Of the bounding box of (k, 3) points."""
    return float(np.linalg.norm(points.max(axis=0) - points.min(axis=0)))


def surface_diagonal(points: NDArray[np.floating], corner_vertices: Ints) -> float:
    """Of the bounding box of the vertices that are in faces, which the solver's radius is a fraction of; 0 for none."""
    if len(corner_vertices) == 0:
        return 0.0
    is_in_face = np.zeros(len(points), dtype=bool)
    is_in_face[corner_vertices] = True
    return diagonal_of(points[is_in_face])


def local_patch(
    native: Any,
    rest_positions: Floats,
    part: Neighbourhood,
    vertices: Ints,
    reach: float,
    stretch: Floats,
    settings: SessionSettings,
) -> Patch | None:
    """As patch_around(), without a model of the whole mesh.

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
    model = make(native, ModelInput(seen, replace(settings, energy="spokes_and_rims", threads=1)))
    local = np.searchsorted(part.vertices, vertices).astype(np.int32)
    unstretch = np.asarray(np.linalg.inv(stretch), dtype=np.float64)
    patch = patch_around(model, local, reach / diagonal_of(seen.rest_positions), unstretch)
    return None if patch is None else replace(patch, vertices=part.vertices[patch.vertices].astype(np.int32))
