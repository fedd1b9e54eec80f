# SPDX-License-Identifier: GPL-3.0-or-later
"""The models of arap_native with an inside that take more than the mesh: bones, tetrahedra."""

from __future__ import annotations

from collections.abc import Sequence

import arap_native
import numpy as np
from measure.base.contender import BONE, HANDLE, PIN, Bones, Floats, Ints, Make, PosedTask

from .bones import bones_of
from .ours import OPTIONS, arrays, targets_of

NO_VERTICES = np.empty(0, dtype=np.int32)


class BonesInVolume:
    """Bones that hold the inside around them, in place of vertices."""

    version = arap_native.__version__

    def __init__(self, task: PosedTask) -> None:
        self._bones, self._positions = task.bones or bones_of(task), task.positions
        self.acts: Sequence[str] = [BONE] * len(self._bones.rest)
        self._model = arap_native.LatticeArap(*arrays(task))
        self._model.set_constraints(NO_VERTICES, segments=self._bones.rest)

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


class Tetrahedra:
    """Tetrahedra cut from the lattice of the mesh; what is constrained are places inside of them."""

    version = arap_native.__version__
    acts: Sequence[str] = (PIN, HANDLE)

    def __init__(self, task: PosedTask) -> None:
        self._task, self._positions = task, task.positions
        self._tets = arap_native.LatticeTets(*arrays(task))
        self._model = arap_native.TetArap(self._tets.rest_positions, self._tets.tets)
        self._model.set_constraints(NO_VERTICES, patches=patches_of(task, self._tets))

    def pose(self, step: int) -> None:
        targets, turns = targets_of(self._task, step)
        self._positions = self._tets.embed(self._model.solve(targets, OPTIONS, rotations=turns).positions)

    def positions(self) -> Floats:
        return self._positions


def patches_of(task: PosedTask, tets: arap_native.LatticeTets) -> tuple[Ints, Ints, Floats]:
    """One for each constrained vertex; what the task moves as an average is one, too."""
    if task.patch_weights is None:
        return tets.patches(task.constrained)
    offsets, vertices, weights = tets.patches(task.held)
    _, of_patch, its_weights = tets.patches(task.moved)
    own, place = np.unique(of_patch, return_inverse=True)
    sums = np.bincount(place.reshape(-1), np.repeat(task.patch_weights, 4) * its_weights)
    return (
        np.concatenate([offsets, [offsets[-1] + len(own)]]).astype(np.int32),
        np.concatenate([vertices, own]).astype(np.int32),
        np.concatenate([weights, sums]),
    )


MODELS: dict[str, Make] = {
    "tetrahedra": Tetrahedra,
    "bones in a volume": BonesInVolume,
}
