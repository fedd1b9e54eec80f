# SPDX-License-Identifier: GPL-3.0-or-later
"""The models of arap_native with an inside that take more than the mesh: bones, tetrahedra."""

from __future__ import annotations

from collections.abc import Sequence

import arap_native
import numpy as np
from measure.base.contender import BONE, HANDLE, PIN, Bones, Floats, Ints, Make, PosedTask

from .bones import bones_of
from .ours import OPTIONS, arrays
from .steps import motion_of_moved

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
    """Tetrahedra cut from the lattice of the mesh.

    Those of which all is held stay, those of which all is moved go along. In others it is held by its vertices, points
    inside of them. Points everywhere would be thousands of constraints in a few tetrahedra.
    """

    version = arap_native.__version__
    acts: Sequence[str] = (PIN, HANDLE)

    def __init__(self, task: PosedTask) -> None:
        self._task, self._positions = task, task.positions
        self._tets = arap_native.LatticeTets(*arrays(task))
        self._model = arap_native.TetArap(self._tets.rest_positions, self._tets.tets)
        is_average = task.patch_weights is not None
        self._held, held_points = whole_and_points(self._tets, task.held)
        self._moved, moved_points = (
            (NO_VERTICES, task.moved) if is_average else whole_and_points(self._tets, task.moved)
        )
        self._held = np.setdiff1d(self._held, self._moved)
        self._points = np.concatenate([held_points, moved_points])
        patches = averaged(self._tets, held_points, task) if is_average else self._tets.patches(self._points)
        self._model.set_constraints(np.concatenate([self._held, self._moved]), patches=patches)

    def pose(self, step: int) -> None:
        rest, (turn, shift) = self._tets.rest_positions, motion_of_moved(self._task, step)
        places = np.empty_like(self._task.positions)
        places[self._task.constrained] = self._task.targets[step]
        points = places[self._points]
        if self._task.patch_weights is not None:
            n_held = len(self._points) - len(self._task.moved)
            points = np.concatenate([points[:n_held], (self._task.patch_weights @ points[n_held:])[None]])
        targets = np.concatenate([rest[self._held], rest[self._moved] @ turn.T + shift, points])
        self._positions = self._tets.embed(self._model.solve(targets, OPTIONS).positions)

    def positions(self) -> Floats:
        return self._positions


def whole_and_points(tets: arap_native.LatticeTets, part: Ints) -> tuple[Ints, Ints]:
    """The corners of the tetrahedra that hold vertices of a part of the surface alone; the vertices in others."""
    tet, n_tets = tets.tet_of_vertex, len(tets.tets)
    part = part[tet[part] >= 0]
    of_part = np.bincount(tet[part], minlength=n_tets)
    is_whole = (of_part > 0) & (of_part == np.bincount(tet[tet >= 0], minlength=n_tets))
    corners = np.unique(tets.tets[is_whole])
    is_corner = np.zeros(len(tets.rest_positions), dtype=bool)
    is_corner[corners] = True
    return corners.astype(np.int32), part[~is_corner[tets.tets[tet[part]]].all(axis=1)]


def averaged(tets: arap_native.LatticeTets, points: Ints, task: PosedTask) -> tuple[Ints, Ints, Floats]:
    """Patches for points of the surface, and one for the average that the task moves."""
    assert task.patch_weights is not None
    offsets, corners, weights = tets.patches(points)
    _, of_average, its_weights = tets.patches(task.moved)
    own, place = np.unique(of_average, return_inverse=True)
    sums = np.bincount(place.reshape(-1), np.repeat(task.patch_weights, 4) * its_weights)
    return (
        np.append(offsets, offsets[-1] + len(own)).astype(np.int32),
        np.concatenate([corners, own]).astype(np.int32),
        np.concatenate([weights, sums]),
    )


MODELS: dict[str, Make] = {
    "tetrahedra": Tetrahedra,
    "solid, bones": BonesInVolume,
}
INPUTS = {
    "tetrahedra": "The targets of held and moved vertices, on tetrahedra cut from the lattice of the solid.",
    "solid, bones": "The task's bones; where it has none, a bone along each piece of what is held and of what is "
    "moved.",
}
