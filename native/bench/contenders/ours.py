# SPDX-License-Identifier: GPL-3.0-or-later
"""The models of arap_native that take a mesh as it is."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import arap_native
import numpy as np
from measure.base.contender import ACCURACY, HANDLE, PIN, STEP_ITERATIONS, TURN, Floats, Make, PosedTask

OPTIONS = arap_native.SolveOptions(accuracy=ACCURACY, max_iterations=STEP_ITERATIONS)
Bind = Callable[[PosedTask], arap_native.Model]


class Posed:
    """A mesh bound, its constraints set. All models are told how what is moved has turned; Poisson editing takes it."""

    version = arap_native.__version__

    def __init__(self, task: PosedTask, bind: Bind, acts: Sequence[str]) -> None:
        self.acts = acts
        self._task, self._model, self._positions = task, bind(task), task.positions
        if task.patch_weights is None:
            self._model.set_constraints(task.constrained)
        else:
            patches = np.array([0, len(task.moved)], dtype=np.int32), task.moved, task.patch_weights
            self._model.set_constraints(task.held, patches=patches)

    def pose(self, step: int) -> None:
        targets, turns = targets_of(self._task, step)
        self._positions = self._model.solve(targets, OPTIONS, rotations=turns).positions

    def positions(self) -> Floats:
        return self._positions

    @property
    def energy(self) -> Callable[[Floats], float] | None:
        """Of positions (n, 3); None where the model minimizes none of them."""
        return getattr(self._model, "energy", None)


def targets_of(task: PosedTask, step: int) -> tuple[Floats, Floats]:
    """Places (t, 3) and rotations (t, 3, 3) of what set_constraints() was told: a patch is one."""
    n_held = len(task.held)
    held, moved = task.targets[step, :n_held], task.targets[step, n_held:]
    if task.patch_weights is not None:
        moved = (task.patch_weights @ moved)[None]
    turns = np.tile(np.eye(3), (n_held + len(moved), 1, 1))
    turns[n_held:] = task.rotations[step]
    return np.concatenate([held, moved]), turns


def arrays(task: PosedTask) -> tuple[Any, Any, Any]:
    return task.positions, task.corner_vertices, task.face_sizes


def surface(energy: Any) -> Bind:
    return lambda task: arap_native.SurfaceArap(*arrays(task), options=arap_native.Options(energy=energy))


def solid(keep_volume: float) -> Bind:
    return lambda task: arap_native.LatticeArap(
        *arrays(task), options=arap_native.LatticeOptions(keep_volume=keep_volume)
    )


def poisson(propagation: Any) -> Bind:
    return lambda task: arap_native.PoissonEditing(
        *arrays(task), options=arap_native.PoissonOptions(propagation=propagation)
    )


def graph(nodes: Any, weights: Any = "smooth") -> Bind:
    return lambda task: arap_native.EmbeddedDeformation(
        *arrays(task), options=arap_native.EmbeddedOptions(nodes=nodes, weights=weights)
    )


def posed(bind: Bind, *acts: str) -> Make:
    return lambda task: Posed(task, bind, acts)


MODELS: dict[str, Make] = {
    "surface, rotation nodes": posed(surface("rotation_nodes"), PIN, HANDLE),
    "surface, spokes and rims": posed(surface("spokes_and_rims"), PIN, HANDLE),
    "surface, spokes": posed(surface("spokes"), PIN, HANDLE),
    "solid": posed(solid(0.0), PIN, HANDLE),
    "solid, Keep Volume": posed(solid(1.0), PIN, HANDLE),
    "Poisson, harmonic": posed(poisson("harmonic"), PIN, HANDLE, TURN),
    "Poisson, geodesic": posed(poisson("geodesic"), PIN, HANDLE, TURN),
    "graph, affine": posed(graph("affine"), PIN, HANDLE),
    "graph, rigid": posed(graph("rigid"), PIN, HANDLE),
    "graph, as published": posed(graph("affine", "nearest"), PIN, HANDLE),
}
WITHOUT_TURNS = "The targets of held and moved vertices."
WITH_TURNS = "The targets of held and moved vertices, and how what is moved has turned."
INPUTS = {name: WITH_TURNS if name.startswith("Poisson") else WITHOUT_TURNS for name in MODELS}
