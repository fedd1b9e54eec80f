# SPDX-License-Identifier: GPL-3.0-or-later
"""The patch of a point handle without a bind of the whole mesh."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats, Ints
from .models import ModelInput, make
from .patches import Ball, diagonal_of, patch_around
from .session_data import SessionMesh, SessionSettings
from .targets import Patch


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
    if patch is None:
        return None
    return replace(patch, vertices=part.vertices[patch.vertices].astype(np.int32), sources=vertices)
