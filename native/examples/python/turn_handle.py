# SPDX-License-Identifier: GPL-3.0-or-later
"""Poisson editing: the turn of a handle spreads over a tube, by one linear solve. It has to be told: a move is none."""

import arap_native
import numpy as np
from shapes import tube, turn

positions, faces = tube()
pins = np.flatnonzero(positions[:, 0] < 0.3)
handle = np.flatnonzero(positions[:, 0] > 5.7)
middle = np.flatnonzero(np.isclose(positions[:, 0], 3))

model = arap_native.PoissonEditing(positions, faces)
model.set_constraints(np.concatenate([pins, handle]))

motion = 1.5 * turn(80, "x")  # a turn, and larger
targets = np.concatenate([positions[pins], positions[handle] @ motion.T])
stays = np.eye(3)
told = {
    "nothing": [stays] * len(pins) + [stays] * len(handle),
    "the motion of the handle": [stays] * len(pins) + [motion] * len(handle),
}
for name, rotations in told.items():
    ring = model.solve(targets, rotations=rotations).positions[middle]
    first = ring[0] - ring.mean(axis=0)
    angle = np.degrees(np.arctan2(first[2], first[1]))
    print(f"told {name}: the middle is turned by {angle:.1f} degrees, its radius is {np.linalg.norm(first):.2f}")
