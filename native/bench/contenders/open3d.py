# SPDX-License-Identifier: GPL-3.0-or-later
"""Open3D from PyPI."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np
import open3d
from measure.base.contender import HANDLE, PIN, STEP_ITERATIONS, Floats, Make, PosedTask
from measure.base.workers import NotRun
from open3d.geometry import DeformAsRigidAsPossibleEnergy as Energy
from open3d.geometry import TriangleMesh
from open3d.utility import IntVector, Vector3dVector, Vector3iVector


class Spokes:
    """Open3D takes the mesh that it is given for the rest shape: each step starts at rest, so that it stays elastic."""

    version = str(open3d.__version__)
    acts: Sequence[str] = (PIN, HANDLE)

    def __init__(self, task: PosedTask) -> None:
        self._rest = TriangleMesh(Vector3dVector(task.positions), Vector3iVector(task.triangles))
        self._vertices, self._targets, self._result = IntVector(task.constrained), task.targets, self._rest

    def pose(self, step: int) -> None:
        targets = Vector3dVector(self._targets[step])
        try:
            deform = self._rest.deform_as_rigid_as_possible
            self._result = deform(self._vertices, targets, STEP_ITERATIONS, Energy.Spokes)
        except RuntimeError as error:
            said = re.sub(r"\x1b\[[0-9;]*m", "", str(error))  # in colour, with the function and its file before it
            raise NotRun(said.rpartition(": ")[2].strip()) from error

    def positions(self) -> Floats:
        return np.array(self._result.vertices, dtype=np.float64)


MODELS: dict[str, Make] = {"Open3D: ARAP, spokes": Spokes}
INPUTS = {
    "Open3D: ARAP, spokes": "The targets of held and moved vertices; every step starts at rest, since Open3D takes "
    "for the rest shape what it starts from.",
}
