# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses a surface: one end of a tube is pinned, the other is a handle that swings up. Writes posed_tube.obj."""

import arap_native
import numpy as np
from shapes import tube, turn, write_obj

positions, faces = tube()
pins = np.flatnonzero(positions[:, 0] < 0.3)
handle = np.flatnonzero(positions[:, 0] > 5.7)

model = arap_native.SurfaceArap(positions, faces)
model.set_constraints(np.concatenate([pins, handle]))

# Each motion of the handle is a solve, which goes on from the one before.
for degrees in (30, 60, 90):
    swung = (positions[handle] - [3, 0, 0]) @ turn(degrees, "z").T + [3, 0, 0]
    result = model.solve(np.concatenate([positions[pins], swung]))
    x, y, _ = result.positions[-1]
    print(f"{degrees} degrees: end at ({x:.2f}, {y:.2f}), energy {result.energy_after:.4f}, {result.stop_reason}")

write_obj("posed_tube.obj", result.positions, faces)
