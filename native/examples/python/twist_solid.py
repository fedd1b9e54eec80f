# SPDX-License-Identifier: GPL-3.0-or-later
"""Twists a tube by 180 degrees: as a surface it loses volume, with its inside it keeps nearly all."""

import arap_native
import numpy as np
from shapes import tube, turn, volume

positions, faces = tube()
pins = np.flatnonzero(positions[:, 0] < 0.3)
handle = np.flatnonzero(positions[:, 0] > 5.7)

models = {
    "surface": arap_native.SurfaceArap(positions, faces),
    "solid": arap_native.LatticeArap(positions, faces),
    "solid that keeps its volume": arap_native.LatticeArap(
        positions, faces, options=arap_native.LatticeOptions(keep_volume=1)
    ),
}
for name, model in models.items():
    model.set_constraints(np.concatenate([pins, handle]))
    # In steps: half a turn at once has no shorter way.
    for degrees in (60, 120, 180):
        result = model.solve(np.concatenate([positions[pins], positions[handle] @ turn(degrees, "x").T]))
    print(f"{name}: {volume(result.positions, faces) / volume(positions, faces):.1%} of the volume")
