# SPDX-License-Identifier: GPL-3.0-or-later
"""The cages of arap_native: made by make_cage, and moved by what is held and moved of the mesh."""

from __future__ import annotations

from typing import Any

import arap_native
import numpy as np
from measure.base.contender import CAGE, CAGE_GROUP, HANDLE, PIN, Floats, Make, PosedTask

from .carriers import automatic_cage


class CageByHandles:
    """A cage whose coordinates carry the mesh."""

    version = arap_native.__version__
    acts = (PIN, HANDLE, CAGE, CAGE_GROUP, CAGE_GROUP)

    def __init__(self, task: PosedTask, coordinates: Any) -> None:
        self._cage, self._positions = automatic_cage(task), task.positions
        options = arap_native.CageOptions(coordinates=coordinates)
        self._carried = arap_native.CageDeformation(task.positions, *self._cage.arrays, options)

    def pose(self, step: int) -> None:
        self._positions = self._carried.deform(self._cage.pose(step))

    def positions(self) -> Floats:
        return np.asarray(self._positions)


def cage(coordinates: str) -> Make:
    return lambda task: CageByHandles(task, coordinates)


MODELS: dict[str, Make] = {
    "cage, mean value": cage("mean_value"),
    "cage, harmonic": cage("harmonic"),
    "cage, Green": cage("green"),
}
INPUTS = dict.fromkeys(
    MODELS,
    "A cage of make_cage: its vertices next to what is held stay, those next to what is moved go along, and surface "
    "ARAP of the cage poses the rest.",
)
