# SPDX-License-Identifier: GPL-3.0-or-later
"""The tetrahedra of arap_native on those that libigl's ARAP gets, to compare both. It needs both libraries."""

from __future__ import annotations

from collections.abc import Sequence

import arap_native
import numpy as np
from measure.base.contender import HANDLE, PIN, Floats, Make, PosedTask

from .libigl import solid
from .ours import OPTIONS


class Tetrahedra:
    version = arap_native.__version__
    acts: Sequence[str] = (PIN, HANDLE)

    def __init__(self, task: PosedTask) -> None:
        self._task = task
        self.places, tets = solid(task)
        self._model = arap_native.TetArap(self.places, tets.astype(np.int32))
        self._model.set_constraints(task.constrained)

    def pose(self, step: int) -> None:
        self.places = self._model.solve(self._task.targets[step], OPTIONS).positions

    def positions(self) -> Floats:
        return np.asarray(self.places[: len(self._task.positions)])

    def energy(self, places: Floats) -> float:
        return self._model.energy(places)


MODELS: dict[str, Make] = {"tetrahedra of TetGen": Tetrahedra}
