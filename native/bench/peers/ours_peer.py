# SPDX-License-Identifier: GPL-3.0-or-later
"""arap_native.

Options of the bind go to arap_native.Options as they are, "initial_guess" and "acceleration" to the solve.
The start is "previous" at rest, as in a drag: one global step with the rotations of the rest shape, which is also how
CGAL and Open3D start.
"""

from __future__ import annotations

from typing import Any

import arap_native
import numpy as np
from measure.inputs.mesh import Mesh
from measure.inputs.tasks import Task
from numpy.typing import NDArray


class Peer:
    version = arap_native.__version__
    binds_in_every_solve = False

    def __init__(self, mesh: Mesh, task: Task, options: dict[str, Any]) -> None:
        self._mesh, self._task = mesh, task
        self._initial_guess = options.pop("initial_guess", "previous")
        self._acceleration = options.pop("acceleration", "conjugate_gradients")
        self._options = arap_native.Options(**options)
        self._model: arap_native.SurfaceArap | None = None
        self._positions = mesh.positions

    def bind(self) -> None:
        self._model = None
        mesh = self._mesh
        model = arap_native.SurfaceArap(mesh.positions, mesh.corner_vertices, mesh.face_sizes, options=self._options)
        model.set_constraints(self._task.vertices, np.ones(len(self._task.vertices)))
        self._model = model

    def solve(self, n_iterations: int) -> None:
        assert self._model is not None
        options = arap_native.SolveOptions(
            initial_guess=self._initial_guess,
            acceleration=self._acceleration,
            max_iterations=n_iterations,
            accuracy=1e-7,
        )
        self._model.reset()
        self._positions = self._model.solve(self._task.targets, options).positions

    def positions(self) -> NDArray[np.float64]:
        return self._positions
