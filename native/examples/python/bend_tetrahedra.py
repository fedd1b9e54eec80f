# SPDX-License-Identifier: GPL-3.0-or-later
"""Bends a bar that is cut into tetrahedra."""

from itertools import permutations

import arap_native
import numpy as np
from shapes import Floats, turn

# A grid of cubes. Each is cut into six tetrahedra: the ways along its edges from its lowest to its highest corner.
n = (24, 4, 4)
positions = np.stack(np.meshgrid(*(np.arange(k + 1) / 4 for k in n), indexing="ij"), axis=-1).reshape(-1, 3)
number = np.arange(len(positions)).reshape([k + 1 for k in n])
lowest = number[:-1, :-1, :-1].reshape(-1, 1)
step = (number[1, 0, 0], number[0, 1, 0], number[0, 0, 1])
tets = np.concatenate([lowest + np.cumsum((0, *way)) for way in permutations(step)])


def grown(points: Floats) -> Floats:
    """Returns the volume of each tetrahedron beside that at rest; it is below 0 where one is turned inside out."""
    now, rest = (np.linalg.det(at[tets[:, 1:]] - at[tets[:, :1]]) for at in (points, positions))
    return np.asarray(now / rest)


pins = np.flatnonzero(positions[:, 0] < 0.3)
handle = np.flatnonzero(positions[:, 0] > 5.7)
model = arap_native.TetArap(positions, tets)
model.set_constraints(np.concatenate([pins, handle]))

swung = (positions[handle] - [3, 0, 0]) @ turn(90, "z").T + [3, 0, 0]
result = model.solve(np.concatenate([positions[pins], swung]))
print(f"{len(tets)} tetrahedra, {result.iterations} iterations, {result.stop_reason}")
volumes = grown(result.positions)  # all are as large at rest
print(f"{volumes.mean():.1%} of the volume, {(volumes <= 0).sum()} turned inside out")
