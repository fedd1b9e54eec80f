# SPDX-License-Identifier: GPL-3.0-or-later
"""A potted cactus with two arms, its pot and its flower, as arrays; needs numpy alone."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin

import numpy as np

from .cage import Cage, ellipse, rings_along
from .quad_mesh import Floats, Ints, QuadMesh, vertex_normals
from .subdivision import catmull_clark

N = 16  # vertices a ring: eight ribs
SOIL = 0.52

TRUNK = (  # z, radius
    (0.40, 0.20), (0.46, 0.24), (0.56, 0.28), (0.70, 0.30), (0.84, 0.31), (0.96, 0.315), (1.08, 0.32), (1.20, 0.32),
    (1.32, 0.32), (1.44, 0.315), (1.56, 0.31), (1.70, 0.30), (1.84, 0.275), (1.94, 0.22), (2.00, 0.13),
)  # fmt: skip
TOP = 2.02
# Centre line and radius of each arm, in the plane y = 0, from the trunk outwards.
RIGHT_ARM = (
    (0.40, 0.985, 0.150), (0.52, 0.985, 0.148), (0.645, 1.02, 0.152), (0.71, 1.12, 0.158), (0.725, 1.25, 0.162),
    (0.72, 1.38, 0.158), (0.715, 1.47, 0.130), (0.712, 1.52, 0.075),
)  # fmt: skip
LEFT_ARM = (
    (-0.39, 1.33, 0.135), (-0.49, 1.33, 0.132), (-0.595, 1.365, 0.136), (-0.65, 1.46, 0.140), (-0.66, 1.57, 0.140),
    (-0.655, 1.66, 0.114), (-0.652, 1.71, 0.065),
)  # fmt: skip
SIDE = (0.0, -1.0, 0.0)  # the arms lie in the plane that this is normal to
RIGHT_BLOCK, LEFT_BLOCK = (3, -2), (6, N // 2 - 2)  # ring, place

POT = (  # radius, z
    (0.30, 0.0), (0.33, 0.01), (0.42, 0.44), (0.43, 0.455), (0.475, 0.46), (0.485, 0.475), (0.495, 0.58),
    (0.49, 0.595), (0.45, 0.595), (0.44, 0.58), (0.43, SOIL), (0.40, SOIL), (0.20, SOIL + 0.02),
)  # fmt: skip
PETALS = (  # radius at the tips, between them, z
    (0.06, 0.05, 0.02), (0.20, 0.09, 0.06), (0.27, 0.10, 0.105), (0.22, 0.085, 0.105), (0.07, 0.06, 0.06),
)  # fmt: skip

GREEN = (0.10, 0.32, 0.12)
LIGHT = (0.42, 0.62, 0.26)
SHADE = (0.035, 0.16, 0.075)


def cactus() -> QuadMesh:
    """The plant alone: closed, all quads; vertex data "color" is linear RGB, (n, 3)."""
    cage = Cage()
    trunk = [_ring(cage, r, ellipse((0, 0, z), (r, 0, 0), (0, r, 0), n=N)) for z, r in TRUNK]
    for lower, upper in pairwise(trunk):
        cage.loft(lower, upper)
    cage.cap(trunk[0][::-1], (0, 0, TRUNK[0][0] - 0.02))
    cage.cap(trunk[-1], (0, 0, TOP))
    _arm(cage, cage.open_block(trunk, *RIGHT_BLOCK, size=4)[::-1], np.array(RIGHT_ARM))
    _arm(cage, cage.open_block(trunk, *LEFT_BLOCK, size=4)[::-1], np.array(LEFT_ARM))
    mesh = catmull_clark(catmull_clark(cage.whole()))
    crest = mesh.vertex_data["crest"]
    mesh.positions += vertex_normals(mesh) * (0.4 * mesh.vertex_data["radius"] * (crest - 0.5))
    mesh.vertex_data["color"] = _colors(crest)
    return mesh


def cactus_groups(mesh: QuadMesh) -> dict[str, Ints]:
    """Vertices of the parts that pins and handles take, by name."""
    x, _, z = mesh.positions.T
    masks = {
        "Roots": z < SOIL + 0.06,
        "Top": (np.abs(x) < 0.35) & (z > 1.78),
        "Arm R": (x > 0.45) & (z > 1.30),
        "Arm L": (x < -0.45) & (z > 1.52),
    }
    return {name: np.flatnonzero(mask).astype(np.int32) for name, mask in masks.items()}


def pot() -> QuadMesh:
    """A pot with soil in it; face data "tag" is 0 clay, 1 soil."""
    cage = Cage()
    rings = [cage.loop(ellipse((0, 0, z), (r, 0, 0), (0, r, 0), n=N)) for r, z in POT]
    for k, (lower, upper) in enumerate(pairwise(rings)):
        cage.tag = int(k >= len(rings) - 3)
        cage.loft(lower, upper)
    cage.cap(rings[-1], (0, 0, SOIL + 0.03))
    cage.tag = 0
    cage.cap(rings[0][::-1], (0, 0, 0))
    return catmull_clark(catmull_clark(cage.whole()))


def flower() -> QuadMesh:
    """A flower of six petals, its foot at the origin; face data "tag" is 0 petals, 1 heart."""
    cage = Cage()
    rings = [cage.loop(_star(0.03, 0.03, -0.03))]
    for outer, inner, z in PETALS:
        rings.append(cage.loop(_star(outer, inner, z)))
        cage.loft(rings[-2], rings[-1])
    cage.tag = 1
    rings.append(cage.loop(_star(0.045, 0.045, 0.085)))
    cage.loft(rings[-2], rings[-1])
    cage.cap(rings[-1], (0, 0, 0.10))
    cage.tag = 0
    cage.cap(rings[0][::-1], (0, 0, -0.03))
    return catmull_clark(catmull_clark(cage.whole()))


def _star(outer: float, inner: float, z: float) -> list[tuple[float, float, float]]:
    radii = (outer, inner) * 6
    return [(r * cos(pi * i / 6), r * sin(pi * i / 6), z) for i, r in enumerate(radii)]


def _ring(cage: Cage, radius: float, points: list[Floats]) -> list[int]:
    """A ring whose every other vertex is on a rib's crest."""
    loop = []
    for i, point in enumerate(points):
        cage.weights = {"crest": float(i % 2), "radius": radius}
        loop.append(cage.vertex(point))
    return loop


def _arm(cage: Cage, loop: list[int], line: Floats) -> None:
    """Lofts an arm from a hole in the trunk, along a line (m, 3) of x, z and radius."""
    centres = np.insert(line[:, :2], 1, 0.0, axis=1)
    radii = line[:, [2, 2]]
    for radius, points in zip(line[:, 2], rings_along(cage, loop, centres, radii, SIDE), strict=True):
        upper = _ring(cage, radius, points)
        cage.loft(loop, upper)
        loop = upper
    end = centres[-1] - centres[-2]
    cage.cap(loop, centres[-1] + 0.01 * end / np.linalg.norm(end))


def _colors(crest: Floats) -> Floats:
    """Dark in the grooves, light along the crests."""
    color = np.array(SHADE) + (np.array(GREEN) - np.array(SHADE)) * np.clip(2.2 * crest, 0, 1)
    return np.asarray(color + (np.array(LIGHT) - color) * np.clip(4 * crest - 2.6, 0, 1))
