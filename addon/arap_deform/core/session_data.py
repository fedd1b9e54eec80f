# SPDX-License-Identifier: GPL-3.0-or-later
"""What a session is made of and what it tells: plain data. No bpy."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .arrays import Floats, Ints

OF_BIND = "Model, cube size, Keep Volume, bending, rigidity, weights, threads, Weld Seams and Loose Pieces Follow"
"""The settings that only a new session can take, see SessionSettings.of_bind."""


@dataclass(frozen=True)
class SessionMesh:
    """A mesh at rest, in object space.

    Attributes:
        rest_positions: (n, 3) float64.
        corner_vertices: (c,) int32, the faces' vertices, one face after the other.
        face_sizes: (f,) int32.
    """

    rest_positions: Floats
    corner_vertices: Ints
    face_sizes: Ints

    @cached_property
    def signature(self) -> int:
        """A fingerprint of the arrays, the positions in single precision."""
        value = 0
        for array in (self.rest_positions.astype(np.float32), self.corner_vertices, self.face_sizes):
            value = zlib.crc32(np.ascontiguousarray(array).tobytes(), value)
        return value


@dataclass(frozen=True)
class SessionSettings:
    """The settings of ``Object.arap``, and of the preferences, that the solver sees; see there for what they mean."""

    model: str = "surface"  # or "solid"
    cube_size: float = 0.0  # of a solid's lattice, a fraction of the mesh's diagonal as seen; 0: from the shape
    keep_volume: float = 0.0  # of a solid, in [0, 1]
    energy: str = "rotation_nodes"
    rigidity_radius: float = 0.02  # a fraction of the mesh's diagonal as seen
    weights: str = "cotangent"
    initial_guess: str = "previous"
    iterations_per_update: int = 4
    max_iterations: int = 1000
    accuracy: float = 1e-6
    threads: int = 0
    join_seams: bool = False
    use_loose_parts: bool = True

    @property
    def of_bind(self) -> tuple[object, ...]:
        """The settings that only a new session can take."""
        radius = self.rigidity_radius if self.has_radius else None
        of_solid = (self.cube_size, self.keep_volume)
        of_model = of_solid if self.model == "solid" else (self.energy, radius, self.weights)
        return self.model, *of_model, self.threads, self.join_seams, self.use_loose_parts

    @property
    def has_radius(self) -> bool:
        """Whether the model and its energy are such that the rigidity radius belongs to them."""
        return self.model == "surface" and self.energy == "rotation_nodes"


@dataclass(frozen=True)
class SolveStats:
    """What the last solve did.

    Attributes:
        energy, energy_before: in the square of world units.
        step: last iteration's largest movement, as a fraction of the size.
        stop_reason: "converged", "max_iterations" or "time_limit".
        last_ms, bind_ms, factor_ms: milliseconds of this solve, of the bind and of the last factorization.
        parts_at_rest: number of connected parts that nothing holds or moves, and that follow nothing.
        outside: names of the bones that pass through nothing, so they move nothing.
    """

    vertices: int
    free_vertices: int
    last_ms: float
    iterations: int
    energy: float
    energy_before: float
    step: float
    stop_reason: str
    parts_at_rest: int
    loose_vertices: int
    outside: tuple[str, ...]
    bind_ms: float
    factor_ms: float


def stats_of_whole(parts: Sequence[SolveStats]) -> SolveStats:
    """The stats of a solve that was done in several updates."""
    return replace(
        parts[-1],
        energy_before=parts[0].energy_before,
        iterations=sum(part.iterations for part in parts),
        last_ms=sum(part.last_ms for part in parts),
    )
