# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of a limb is left when it is posed: its volume, and the thinnest of its plane sections."""

from __future__ import annotations

import numpy as np

from ..inputs.limbs import Limb
from ..inputs.mesh import Floats, Ints

N_SECTIONS = 31


def volume(positions: Floats, triangles: Ints) -> float:
    """What closed triangles enclose."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    return float(np.einsum("fi,fi->", a, np.cross(b, c)) / 6)


def section_area(heights: Floats, positions: Floats, triangles: Ints) -> float:
    """Area of the curve that a surface at rest has in a plane, wherever its points are now.

    Args:
        heights: (n,) of the vertices at rest above the plane; none is exactly 0.
        positions: (n, 3) now.
        triangles: (f, 3) of one closed limb.
    """
    above = heights[triangles] > 0.0
    crossed = triangles[above.any(axis=1) & ~above.all(axis=1)]
    ends = []
    for is_up in (True, False):  # where the way around a triangle comes up through the plane, and where it goes down
        first, second = (np.roll(crossed, -k, axis=1) for k in range(2))
        side = ((heights[first] > 0.0) != is_up) & ((heights[second] > 0.0) == is_up)
        i, j = first[side], second[side]
        share = (heights[i] / (heights[i] - heights[j]))[:, None]
        ends.append((1.0 - share) * positions[i] + share * positions[j])
    start, end = ends
    middle = start.mean(axis=0)
    return float(0.5 * np.linalg.norm(np.cross(start - middle, end - middle).sum(axis=0)))


def thinnest_section(limb: Limb, positions: Floats) -> float:
    """The least area of the limb's sections over that at rest."""
    rest, triangles = limb.pose.mesh.positions, limb.pose.mesh.triangles
    triangles = triangles[limb.is_limb[triangles].all(axis=1)]
    along = limb.high - limb.low
    shares = (rest - limb.low) @ along / (along @ along)
    found = []
    for share in np.linspace(0.0, 1.0, N_SECTIONS) + 1.1e-5:
        heights = shares - share
        found.append(section_area(heights, positions, triangles) / section_area(heights, rest, triangles))
    return min(found)
