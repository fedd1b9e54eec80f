# SPDX-License-Identifier: GPL-3.0-or-later
"""The cages of arap_native: made by make_cage, and moved by what is held and moved of the mesh."""

from __future__ import annotations

from typing import Any

import arap_native
import numpy as np
from measure.base.contender import CAGE, CAGE_GROUP, HANDLE, PIN, Floats, Make, PosedTask

from .carriers import automatic_cage
from .ours import arrays, posed


class CageByHandles:
    """A cage whose coordinates carry the mesh, but for vertices in no face: they may be outside of it, and stay."""

    version = arap_native.__version__
    acts = (CAGE, CAGE_GROUP, CAGE_GROUP, HANDLE)

    def __init__(self, task: PosedTask, coordinates: Any) -> None:
        self._cage, self._positions = automatic_cage(task), task.positions.copy()
        self._carried_vertices = np.unique(task.corner_vertices)
        options = arap_native.CageOptions(coordinates=coordinates)
        points = task.positions[self._carried_vertices]
        self._carried = arap_native.CageDeformation(points, *self._cage.arrays, options=options)

    def pose(self, step: int) -> None:
        self._positions[self._carried_vertices] = self._carried.deform(self._cage.pose(step))

    def positions(self) -> Floats:
        return self._positions


def cage(coordinates: str) -> Make:
    return lambda task: CageByHandles(task, coordinates)


def cage_arap(energy: Any) -> Make:
    def bind(task: PosedTask) -> arap_native.Model:
        around = arap_native.make_cage(*arrays(task))
        return arap_native.CageArap(*arrays(task), options=arap_native.CageArapOptions(energy=energy), cage=around)

    return posed(bind, PIN, HANDLE, CAGE)


BY_HANDLES: dict[str, Make] = {
    "cage, mean value": cage("mean_value"),
    "cage, harmonic": cage("harmonic"),
    "cage, Green": cage("green"),
}
MODELS: dict[str, Make] = {
    **BY_HANDLES,
    "ARAP on a cage": cage_arap("cage"),
    "ARAP on a cage, the mesh's energy": cage_arap("mesh"),
}
INPUTS = {
    **dict.fromkeys(
        BY_HANDLES,
        "A cage of make_cage: its vertices next to what is held stay, those next to what is moved go along, and "
        "surface ARAP of the cage poses the rest.",
    ),
    "ARAP on a cage": "A cage of make_cage, and the targets of held and moved vertices of the mesh.",
    "ARAP on a cage, the mesh's energy": "The same; what is kept is the shape of the mesh, not of the cage.",
}
