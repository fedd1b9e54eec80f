# SPDX-License-Identifier: GPL-3.0-or-later
"""The models of arap_native with an inside that take more than the mesh: bones, tetrahedra."""

from __future__ import annotations

import arap_native
import numpy as np
from measure.base.contender import BONE, Bones, Floats, Make, PosedTask
from measure.base.workers import NotRun

from .ours import OPTIONS, arrays

NO_VERTICES = np.empty(0, dtype=np.int32)


class BonesInVolume:
    """Bones that hold the inside around them, in place of vertices."""

    version = arap_native.__version__

    def __init__(self, task: PosedTask) -> None:
        if task.bones is None:
            raise NotRun("this task is not done with bones")
        self.acts = [BONE] * len(task.bones.rest)
        self._bones, self._positions = task.bones, task.positions
        self._model = arap_native.LatticeArap(*arrays(task))
        self._model.set_constraints(NO_VERTICES, segments=task.bones.rest)

    def pose(self, step: int) -> None:
        self._positions = self._model.solve(segment_targets(self._bones, step), OPTIONS).positions

    def positions(self) -> Floats:
        return self._positions


def segment_targets(bones: Bones, step: int) -> Floats:
    """(4 b, 3): of each bone its head, and the places that are its length from it along x, y and z at rest."""
    lengths = np.linalg.norm(bones.rest[:, 1] - bones.rest[:, 0], axis=1)
    offsets = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    turned = np.einsum("bij,kj->bki", bones.rotations[step], offsets) * lengths[:, None, None]
    return np.ascontiguousarray((bones.heads[step][:, None] + turned).reshape(-1, 3))


MODELS: dict[str, Make] = {
    "bones in a volume": BonesInVolume,
}
