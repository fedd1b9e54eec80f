# SPDX-License-Identifier: GPL-3.0-or-later
"""Open3D from PyPI, which has spokes alone and binds anew in every call."""

from __future__ import annotations

from typing import Any

import numpy as np
import open3d
from measure.inputs.mesh import Mesh
from measure.inputs.tasks import Task
from numpy.typing import NDArray


class Peer:
    version = str(open3d.__version__)
    binds_in_every_solve = True

    def __init__(self, mesh: Mesh, task: Task, options: dict[str, Any]) -> None:
        if options["energy"] != "spokes":
            raise ValueError("Open3D has spokes alone")
        utility = open3d.utility
        self._mesh = open3d.geometry.TriangleMesh(
            utility.Vector3dVector(mesh.positions), utility.Vector3iVector(mesh.triangles)
        )
        self._vertices = utility.IntVector(task.vertices)
        self._targets = utility.Vector3dVector(task.targets)
        self._result = self._mesh

    def bind(self) -> None:
        # No iterations: everything that comes before them.
        self.solve(0)

    def solve(self, n_iterations: int) -> None:
        self._result = self._mesh.deform_as_rigid_as_possible(self._vertices, self._targets, n_iterations)

    def positions(self) -> NDArray[np.float64]:
        return np.array(self._result.vertices, dtype=np.float64)
