# SPDX-License-Identifier: GPL-3.0-or-later
"""A pose on a bound mesh: solved to its end, and how many iterations come near it."""

from __future__ import annotations

import math
from typing import Any, Literal, NamedTuple

import arap_native
import numpy as np

from ..base.convergence import Run, descend, reach
from ..inputs.mesh import Floats, Ints
from ..inputs.poses import Pose

ModelName = Literal["plain", "nodes"]
MODELS: dict[ModelName, Any] = {"plain": "spokes_and_rims", "nodes": "rotation_nodes"}  # their energies
NEAR = 1.01
STEP_ITERATIONS = 30  # of each step but the last
MOST_ITERATIONS = 3000
ACCURACY = 1e-6  # a fraction of the diagonal, where a pose counts as reached
BEST_ACCURACY = 1e-7  # below it the library works in double alone
Patches = tuple[Ints, Ints, Floats]


def solve_options(iterations: int, accuracy: float, limit_s: float = math.inf) -> arap_native.SolveOptions:
    return arap_native.SolveOptions(max_iterations=iterations, accuracy=accuracy, time_limit_s=limit_s)


class Limit(NamedTuple):
    """What a frame of a drag may take."""

    iterations: int = MOST_ITERATIONS
    s: float = math.inf


class Posed(NamedTuple):
    """A pose solved to its end: positions (n, 3), and whether the accuracy ended it, not a limit."""

    positions: Floats
    energy: float
    is_converged: bool


class Posing:
    """A mesh bound, and the pose's parts constrained."""

    def __init__(self, pose: Pose, model: ModelName) -> None:
        mesh, options = pose.mesh, arap_native.Options(energy=MODELS[model])
        self._arap = arap_native.SurfaceArap(mesh.positions, mesh.corner_vertices, mesh.face_sizes, options=options)
        self._pose = pose
        vertices = pose.task(0.0).vertices
        patches: Patches | None = None
        self._patch_at_rest: Floats = np.empty((0, 3))
        if pose.patch_radius:
            around, weights, average = self._arap.patch_around(pose.moved, pose.patch_radius)
            patches = np.array([0, len(around)], dtype=np.int32), around, weights
            self._patch_at_rest = average[None]
        self._arap.set_constraints(vertices, np.ones(len(vertices)), patches)

    def targets(self, share: float) -> Floats:
        """One row for each constrained vertex, and one for the patch where there is one."""
        return np.concatenate([self._pose.task(share).targets, self._pose.motion(self._patch_at_rest, share)])

    def pose(self, steps: int, limit_s: float, accuracy: float = ACCURACY) -> Posed:
        """From rest in even steps, the last one to its end, or as far as it comes in ``limit_s`` seconds."""
        self._arap.reset()
        for step in range(1, steps):
            self._arap.solve(self.targets(step / steps), solve_options(STEP_ITERATIONS, ACCURACY))
        return self.follow(1.0, limit_s, accuracy)

    def follow(self, share: float, limit_s: float, accuracy: float = ACCURACY) -> Posed:
        """From where it is to the end of a share of the pose."""
        result = self._arap.solve(self.targets(share), solve_options(MOST_ITERATIONS, accuracy, limit_s))
        return Posed(result.positions, result.energy_after, result.stop_reason == "converged")

    def frame(self, share: float, limit: Limit, out: np.typing.NDArray[np.float32]) -> int:
        """What a frame of a drag solves within its limit; into ``out`` (n, 3); the number of iterations."""
        options = solve_options(limit.iterations, ACCURACY, limit.s)
        return self._arap.solve(self.targets(share), options, out=out).iterations

    def reset(self) -> None:
        self._arap.reset()

    def iterations_near(self, budget_s: float) -> tuple[int, bool] | None:
        """Iterations from rest, in one step, to NEAR of the minimum, and whether the minimum is known; None in vain."""
        targets = self.targets(1.0)

        def solve(n_iterations: int) -> Run:
            self._arap.reset()
            options = solve_options(n_iterations, BEST_ACCURACY, budget_s)
            result = self._arap.solve(targets, options)
            return Run(n_iterations, 0.0, result.energy_after)

        descent = descend(solve, budget_s)
        near = reach(solve, descent, NEAR * descent.minimum, n_repeats=1)
        return (near.iterations, descent.is_converged) if near else None
