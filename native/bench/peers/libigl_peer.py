# SPDX-License-Identifier: GPL-3.0-or-later
"""libigl from PyPI."""

from __future__ import annotations

from importlib.metadata import version
from typing import Any

import igl
import numpy as np
from measure.inputs.mesh import Mesh
from measure.inputs.tasks import Task
from numpy.typing import NDArray

ENERGIES = {"spokes": igl.ARAP_ENERGY_TYPE_SPOKES, "spokes_and_rims": igl.ARAP_ENERGY_TYPE_SPOKES_AND_RIMS}


class Peer:
    version = version("libigl")
    binds_in_every_solve = False

    def __init__(self, mesh: Mesh, task: Task, options: dict[str, Any]) -> None:
        self._rest, self._task, self._energy = mesh.positions, task, ENERGIES[options["energy"]]
        self._triangles = mesh.triangles.astype(np.int64)
        self._data: igl.ARAPData | None = None
        self._positions = mesh.positions

    def bind(self) -> None:
        self._data = igl.ARAPData()
        self._data.energy = self._energy
        igl.arap_precomputation(self._rest, self._triangles, 3, self._task.vertices, self._data)

    def solve(self, n_iterations: int) -> None:
        assert self._data is not None
        self._data.max_iter = n_iterations
        self._positions = igl.arap_solve(self._task.targets, self._data, self._rest)

    def positions(self) -> NDArray[np.float64]:
        return np.ascontiguousarray(self._positions)
