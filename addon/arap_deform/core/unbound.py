# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be said of a handle without a bind: the patch of a point, and how a new one leaves a posed mesh in place."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats, Ints
from .models import ModelInput, begin_bind
from .patches import Ball, begin_patches, diagonal_of, patches_from
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
    """As patches_from() for one point, without a model of the whole mesh.

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
    found = begin_patches(model, [local], [reach / diagonal_of(seen.rest_positions)]).result()
    (patch,) = patches_from(found, [local], unstretch)
    if patch is None:
        return None
    return replace(patch, vertices=part.vertices[patch.vertices].astype(np.int32), sources=vertices)


class Pulls:
    """Where handles pull vertices: to the mean of their targets, weighted by strength, as strongly as the strongest."""

    def __init__(self, n: int) -> None:
        """Without any handle yet, for ``n`` vertices."""
        self._total: Floats = np.zeros(n)
        self._largest: Floats = np.zeros(n)
        self._pulled: Floats = np.zeros((n, 3))

    def add(self, vertices: Ints, weights: Floats, targets: Floats) -> None:
        """A handle pulls (k,) ``vertices``, each once, to (k, 3) ``targets``."""
        self._total[vertices] += weights
        self._largest[vertices] = np.maximum(self._largest[vertices], weights)
        self._pulled[vertices] += weights[:, None] * targets

    def staying_targets(self, vertices: Ints, weights: Floats, shown: NDArray[np.floating]) -> Floats:
        """(k, 3) where a new handle must pull these vertices to, so that they stay where they are shown.

        A vertex that no other handle holds: where it is shown. Else the target makes up for the new mean and the new
        strength.

        Args:
            shown: (k, 3).
        """
        here = shown.astype(np.float64)
        total, largest, pulled = self._total[vertices], self._largest[vertices], self._pulled[vertices]
        is_shared = total > 0.0
        before = np.where(is_shared[:, None], pulled / np.where(is_shared, total, 1.0)[:, None], here)
        # With a larger stiffness w / (1 - w) the mean must be nearer for the same force.
        is_stronger = weights > largest
        softness = (1.0 - weights) / (weights * np.where(is_stronger, 1.0 - largest, 1.0))
        share = np.where(is_stronger, largest * softness, 1.0)
        mean = here + share[:, None] * (before - here)
        return np.asarray(mean + (total / weights)[:, None] * (mean - before))
