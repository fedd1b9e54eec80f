# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a cage around a tube and bends it: the tube follows at once, since nothing is solved."""

import arap_native
import numpy as np
from shapes import Floats, tube, turn, volume

positions, faces = tube()
cage, cage_faces = arap_native.make_cage(positions, faces, cells=12)
print(f"a cage of {len(cage)} vertices and {len(cage_faces)} quads around {len(positions)} vertices")


def bent(points: Floats) -> Floats:
    """Beyond x = 3 all is turned by 40 degrees."""
    return np.where(points[:, :1] > 3, (points - [3, 0, 0]) @ turn(40, "z").T + [3, 0, 0], points)


for coordinates in ("mean_value", "green", "harmonic"):
    options = arap_native.CageOptions(coordinates=coordinates)
    model = arap_native.CageDeformation(positions, cage, cage_faces, options=options)
    posed = model.deform(bent(cage))
    x, y, _ = posed[-1]
    print(
        f"{coordinates}: end at ({x:.2f}, {y:.2f}), {volume(posed, faces) / volume(positions, faces):.0%} of the volume"
    )
