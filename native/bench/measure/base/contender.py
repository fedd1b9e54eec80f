# SPDX-License-Identifier: GPL-3.0-or-later
"""What a model gets and gives that takes part in the comparison, ours or another library's.

A module of ``contenders`` has MODELS: a name and what makes its contender of a task, and INPUTS: of each, in a
sentence, what of a task it is given. Names of other libraries' models begin with the library's: "libigl: ARAP".
contenders/worker.py runs one in a process of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int32]

ACCURACY = 1e-5  # of each step, a fraction of the diagonal
STEP_ITERATIONS = 200  # at most, where a model has no measure of its accuracy
# Acts of a person that sets a model up; a bone, or a group of a cage's vertices, is an act each.
PIN, HANDLE, TURN, CAGE = "what stays", "what moves", "how it turns", "a cage around it"
CAGE_GROUP, BONE = "the cage's vertices beside what is held or moved", "a bone"


class Bones(NamedTuple):
    """Bones that do the task for models that have them.

    Attributes:
        rest: (b, 2, 3) heads and tails.
        rotations: (steps, b, 3, 3) since rest.
        heads: (steps, b, 3) where the heads go.
    """

    rest: Floats
    rotations: Floats
    heads: Floats

    def moved(self, step: int, bone: int, points: Floats) -> Floats:
        """(k, 3) where a bone takes points (k, 3) at rest."""
        return np.asarray((points - self.rest[bone, 0]) @ self.rotations[step, bone].T + self.heads[step, bone])


class PosedTask(NamedTuple):
    """A mesh and where some of its vertices go, step after step from rest.

    Attributes:
        positions: (n, 3) at rest, float64, bounding-box diagonal 1.
        corner_vertices: (c,) int32, the faces' vertices, one face after the other.
        face_sizes: (f,) int32; all 3, but in dirty meshes.
        held, moved: (k,), (m,) int32, vertices that stay, and that go where the targets say.
        targets: (steps, k + m, 3) of the held ones, then of the moved ones.
        rotations: (steps, 3, 3) of what is moved, since rest.
        patch_weights: (m,) of sum 1: the average of the moved vertices with these weights goes to that of their
            targets. A model that holds no averages moves them all. None: each goes to its target.
        bones: None where none can do the task.
    """

    positions: Floats
    corner_vertices: Ints
    face_sizes: Ints
    held: Ints
    moved: Ints
    targets: Floats
    rotations: Floats
    patch_weights: Floats | None = None
    bones: Bones | None = None

    @property
    def steps(self) -> int:
        return len(self.targets)

    @property
    def constrained(self) -> Ints:
        """(k + m,) in the order of the targets."""
        return np.concatenate([self.held, self.moved])

    @property
    def triangles(self) -> Ints:
        """(t, 3) int32, each face as a fan from its first corner."""
        sizes = np.maximum(self.face_sizes - 2, 0)
        first = np.repeat(np.cumsum(self.face_sizes) - self.face_sizes, sizes)
        within = np.arange(len(first)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
        corners = np.stack([first, first + within + 1, first + within + 2], axis=1)
        return np.asarray(self.corner_vertices[corners], dtype=np.int32)


class Contender(Protocol):
    """A model bound to a task; making it is the set-up that is timed, bind and constraints.

    Raises measure.base.workers.NotRun, with one sentence why, where the model cannot do the task.

    Attributes:
        version: of its library.
        acts: what a person does to set it up, one string for each act.
    """

    @property
    def version(self) -> str: ...
    @property
    def acts(self) -> Sequence[str]: ...

    def pose(self, step: int) -> None:
        """Goes from where it is to the targets of a step, from 0 on, until it is as near as ACCURACY."""

    def positions(self) -> Floats:
        """(n, 3) float64, where the last step ended."""


Make = Callable[[PosedTask], Contender]


def write_posed(path: Path, task: PosedTask) -> None:
    """As .npz, with the names of the attributes."""
    arrays: dict[str, Any] = {name: value for name, value in task._asdict().items() if isinstance(value, np.ndarray)}
    if task.bones is not None:
        arrays |= {f"bones_{name}": value for name, value in task.bones._asdict().items()}
    np.savez(path, **arrays)


def read_posed(path: Path) -> PosedTask:
    """What write_posed wrote."""
    with np.load(path) as data:
        arrays = dict(data)
    of_bones = [arrays.pop(f"bones_{name}", None) for name in Bones._fields]
    bones = None if any(value is None for value in of_bones) else Bones(*of_bones)
    return PosedTask(**arrays, bones=bones)
