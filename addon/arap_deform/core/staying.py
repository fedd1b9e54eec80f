# SPDX-License-Identifier: GPL-3.0-or-later
"""What a handle that is added to a posed mesh must pull to, so that the mesh stays. No bpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats, Ints
from .targets import HandleSpec
from .transforms import transformed


@dataclass(frozen=True)
class Moved:
    """A handle where it is now.

    Attributes:
        spec: without the vertices of which it holds an average.
        matrix: (4, 4) its object-space motion.
    """

    spec: HandleSpec
    matrix: Floats

    def targets(self, rest: NDArray[np.floating], vertices: Ints) -> Floats:
        """(k, 3) where it pulls these vertices to."""
        return transformed(self.matrix, self.spec.base_or(rest)[vertices].astype(np.float64))


def staying_targets(
    spec: HandleSpec, others: Sequence[Moved], rest: NDArray[np.floating], shown: NDArray[np.floating]
) -> Floats:
    """(k, 3) where a new handle must pull its vertices to, so that the mesh stays as it is shown.

    A vertex that no other handle holds: where it is shown. Else the handles pull it to the mean of their targets,
    weighted by strength, as strongly as the strongest. So the target makes up for the new mean and the new strength.

    Args:
        spec: the new handle.
        others: all others.
        rest, shown: (n, 3) the mesh.
    """
    n = len(rest)
    total: Floats = np.zeros(n)
    largest: Floats = np.zeros(n)
    pulled: Floats = np.zeros((n, 3))
    for other in others:
        vertices, weights = other.spec.vertices, other.spec.weights
        total[vertices] += weights
        largest[vertices] = np.maximum(largest[vertices], weights)
        pulled[vertices] += weights[:, None] * other.targets(rest, vertices)
    vertices, weights = spec.vertices, spec.weights
    here = shown[vertices].astype(np.float64)
    total, largest, pulled = total[vertices], largest[vertices], pulled[vertices]
    is_shared = total > 0.0
    before = np.where(is_shared[:, None], pulled / np.where(is_shared, total, 1.0)[:, None], here)
    # With a larger stiffness w / (1 - w) the mean must be nearer for the same force.
    is_stronger = weights > largest
    softness = (1.0 - weights) / (weights * np.where(is_stronger, 1.0 - largest, 1.0))
    share = np.where(is_stronger, largest * softness, 1.0)
    mean = here + share[:, None] * (before - here)
    return np.asarray(mean + (total / weights)[:, None] * (mean - before))
