# SPDX-License-Identifier: GPL-3.0-or-later
"""libigl from PyPI, and the TetGen that it brings along."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib.metadata import version
from typing import Any

import igl
import numpy as np
from igl.copyleft import tetgen
from measure.base.contender import HANDLE, PIN, TURN, Contender, Floats, Make, PosedTask
from measure.base.workers import NotRun
from numpy.typing import NDArray

from .printed import Printed
from .steps import CALL_ITERATIONS, diagonal, motion_of_moved, settled

TET_EDGE = 0.04  # of the diagonal, which tetrahedra inside have at most, about
SURFACE_INPUT = "The targets of held and moved vertices."
LINEAR_INPUT = "How far held and moved vertices go from rest; it takes no turns."
Indices = NDArray[np.int64]
Elements = Callable[[PosedTask], tuple[Floats, Indices]]


class Peer:
    """What all have.

    Attributes:
        places: (v, 3) where the surface's vertices are, and after them those inside, if the model has some.
    """

    version = version("libigl")
    acts: Sequence[str] = (PIN, HANDLE)

    def __init__(self, task: PosedTask) -> None:
        self._task, self.places = task, task.positions

    def positions(self) -> Floats:
        return np.asarray(self.places[: len(self._task.positions)])


class Arap(Peer):
    def __init__(self, task: PosedTask, elements: Elements, energy: Any) -> None:
        super().__init__(task)
        self.places, corners = elements(task)
        self._data = igl.ARAPData()
        self._data.energy, self._data.max_iter = energy, CALL_ITERATIONS
        igl.arap_precomputation(self.places, corners, 3, task.constrained, self._data)

    def pose(self, step: int) -> None:
        targets = self._task.targets[step]
        self.places = settled(lambda start: igl.arap_solve(targets, self._data, start), self.places)


class Harmonic(Peer):
    def __init__(self, task: PosedTask, power: int) -> None:
        super().__init__(task)
        self._triangles, self._power = surface(task)[1], power

    def pose(self, step: int) -> None:
        rest, vertices = self._task.positions, self._task.constrained
        moves = self._task.targets[step] - rest[vertices]
        self.places = rest + igl.harmonic(rest, self._triangles, vertices.astype(np.int64), moves, self._power)


class BoundedBiharmonic(Peer):
    acts = (PIN, HANDLE, TURN)

    def __init__(self, task: PosedTask) -> None:
        super().__init__(task)
        places, tets = solid(task)
        of_held = np.arange(len(task.constrained)) < len(task.held)
        ones = np.stack([of_held, ~of_held], axis=1).astype(np.float64)
        weights = igl.bbw(places, tets, task.constrained.astype(np.int64), ones)[: len(task.positions)]
        self._blend = igl.lbs_matrix(task.positions, weights / weights.sum(axis=1, keepdims=True))

    def pose(self, step: int) -> None:
        turn, shift = motion_of_moved(self._task, step)
        stays = np.eye(4, 3)
        self.places = self._blend @ np.concatenate([stays, turn.T, shift[None]])


def surface(task: PosedTask) -> tuple[Floats, Indices]:
    return task.positions, task.triangles.astype(np.int64)


def solid(task: PosedTask) -> tuple[Floats, Indices]:
    """Places and tetrahedra; the surface's vertices come first.

    Raises:
        NotRun: TetGen refuses, with its words.
    """
    largest = (TET_EDGE * diagonal(task)) ** 3 / np.sqrt(72)
    switches = f"pYq1.414a{largest:.3e}"  # Y: the surface stays as it is, its vertices first
    printed = Printed()
    try:
        with printed:
            places, tets, *_ = tetgen.tetrahedralize(*surface(task), flags=switches)
    except RuntimeError as error:
        raise NotRun(f"TetGen: {printed.after('Exception:') or printed.after('tetrahedralize:') or error}") from error
    return places, np.ascontiguousarray(tets)


def fast(_: PosedTask) -> Contender:
    raise NotRun("the Python package does not have it (arap_dof.h of the C++ library)")


MODELS: dict[str, Make] = {
    "libigl: ARAP, spokes": lambda task: Arap(task, surface, igl.ARAP_ENERGY_TYPE_SPOKES),
    "libigl: ARAP, spokes and rims": lambda task: Arap(task, surface, igl.ARAP_ENERGY_TYPE_SPOKES_AND_RIMS),
    "libigl: ARAP, tetrahedra": lambda task: Arap(task, solid, igl.ARAP_ENERGY_TYPE_ELEMENTS),
    "libigl: harmonic": lambda task: Harmonic(task, 1),
    "libigl: biharmonic": lambda task: Harmonic(task, 2),
    "libigl: bounded biharmonic weights": BoundedBiharmonic,
    "libigl: fast automatic skinning": fast,
}
INPUTS = {
    "libigl: ARAP, spokes": SURFACE_INPUT,
    "libigl: ARAP, spokes and rims": SURFACE_INPUT,
    "libigl: ARAP, tetrahedra": "The targets of held and moved vertices, on TetGen's tetrahedra of the surface.",
    "libigl: harmonic": LINEAR_INPUT,
    "libigl: biharmonic": LINEAR_INPUT,
    "libigl: bounded biharmonic weights": "The motions of two handles, what is held and what is moved, blended with "
    "weights on TetGen's tetrahedra.",
    "libigl: fast automatic skinning": "Not run.",
}
