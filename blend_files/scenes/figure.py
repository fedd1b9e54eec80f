# SPDX-License-Identifier: GPL-3.0-or-later
"""A child that stands with its arms a bit spread: closed, all quads, mirror-symmetric in x; needs numpy alone.

It faces -y, stands on z = 0 and is 1.8 m high. What it wears is in ``figure_clothes`` and ``figure_head``.
"""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin
from typing import NamedTuple

import numpy as np

from .cage import Cage, ellipse, rings_along
from .quad_mesh import Floats, Ints, QuadMesh
from .subdivision import catmull_clark

SKIN, SCALP, TROUSERS, SHOES = range(4)
COVERED = 4  # added to the tag of what the shirt covers

HALF = 9  # vertices of a half ring, from the front to the back


class Ring(NamedTuple):
    """A half ring around the middle of the figure."""

    z: float
    radius_x: float
    radius_y: float
    y: float = 0.0


RINGS = (  # from the hips to the top of the head
    Ring(0.535, 0.215, 0.160),
    Ring(0.595, 0.225, 0.170),
    Ring(0.650, 0.218, 0.168),  # the shirt begins
    Ring(0.705, 0.206, 0.160),
    Ring(0.760, 0.198, 0.155),  # the trousers end
    Ring(0.815, 0.198, 0.153),
    Ring(0.875, 0.204, 0.152),  # arms: this ring and two more
    Ring(0.940, 0.208, 0.150),
    Ring(1.000, 0.198, 0.144),
    Ring(1.050, 0.165, 0.128),
    Ring(1.085, 0.120, 0.106, 0.005),  # the shirt ends
    Ring(1.115, 0.092, 0.090, 0.008),
    Ring(1.150, 0.090, 0.090, 0.008),  # neck
    Ring(1.175, 0.140, 0.145),
    Ring(1.215, 0.240, 0.230, -0.01),
    Ring(1.280, 0.305, 0.282, -0.01),
    Ring(1.350, 0.330, 0.302, -0.01),  # ears
    Ring(1.425, 0.340, 0.310, -0.01),
    Ring(1.500, 0.338, 0.312, -0.01),
    Ring(1.575, 0.320, 0.300, -0.005),
    Ring(1.645, 0.286, 0.272),
    Ring(1.705, 0.236, 0.226),
    Ring(1.755, 0.168, 0.160),
    Ring(1.785, 0.086, 0.082),
)
TOP = (0.0, 0.0, 1.800)
HEM, TROUSERS_END, ARM, COLLAR, NAPE, EAR, EYES, CROWN = 2, 4, 6, 10, 15, 16, 17, 20  # rings
SIDE = 6  # vertices of a half ring from the front to where the hair begins
NOSE = (0.0, -0.085, -0.01)  # a shift of a vertex of the eyes' ring

LEG = (  # x, y, z, radius in x and in y
    (0.112, 0.000, 0.440, 0.112, 0.130),
    (0.114, 0.000, 0.370, 0.104, 0.116),
    (0.115, 0.000, 0.300, 0.098, 0.106),
    (0.115, 0.000, 0.230, 0.096, 0.102),
    (0.115, 0.000, 0.165, 0.098, 0.102),  # the trousers end
    (0.115, -0.004, 0.150, 0.086, 0.090),
    (0.116, -0.015, 0.110, 0.092, 0.108),
    (0.118, -0.045, 0.065, 0.102, 0.150),
    (0.118, -0.055, 0.018, 0.106, 0.168),
    (0.118, -0.055, 0.001, 0.080, 0.132),
)
SHOE = 5  # ring of the leg
CROTCH = ((0.0, 0.085, 0.470), (0.0, 0.0, 0.455), (0.0, -0.085, 0.470))

ARM_LINE = (  # x, z, radius in the plane of the arms, radius in y
    (0.245, 0.925, 0.086, 0.088),
    (0.295, 0.892, 0.080, 0.080),
    (0.345, 0.856, 0.075, 0.075),
    (0.395, 0.818, 0.071, 0.071),  # the sleeve ends
    (0.445, 0.778, 0.067, 0.067),
    (0.495, 0.737, 0.063, 0.063),
    (0.540, 0.700, 0.058, 0.058),
    (0.575, 0.671, 0.058, 0.056),
    (0.612, 0.640, 0.074, 0.058),
    (0.655, 0.604, 0.086, 0.056),
    (0.697, 0.569, 0.082, 0.052),
    (0.730, 0.541, 0.062, 0.044),
    (0.749, 0.525, 0.034, 0.028),
)
SLEEVE, HAND = 3, 8  # rings of the arm
THUMB = ((0.632, -0.060, 0.655), (0.652, -0.095, 0.648), (0.675, -0.125, 0.632), (0.690, -0.142, 0.618))
THUMB_RADII = (0.044, 0.042, 0.038, 0.022)
EAR_LINE = ((0.318, 0.005, 1.425), (0.345, 0.010, 1.427), (0.374, 0.018, 1.430), (0.388, 0.022, 1.432))
EAR_RADII = ((0.052, 0.080), (0.062, 0.098), (0.058, 0.092), (0.034, 0.058))  # in y and in z
HEAD_CENTRE = np.array([0.0, -0.005, 1.470])

COLOR = (0.87, 0.55, 0.38)
BLUSH = (0.88, 0.28, 0.20)
CHEEK, NOSE_TIP = (0.175, -0.250, 1.335), (0.0, -0.360, 1.415)
CHEEK_SIZE, NOSE_SIZE = 0.060, 0.038


def figure() -> QuadMesh:
    """The figure without clothes.

    Face data "tag" is SKIN, SCALP, TROUSERS or SHOES, "covered" 1 where the shirt is; vertex data "color" is linear RGB
    of the skin, (n, 3), "loose" 1 at the shirt's edges and 0 away from them, (n, 1).
    """
    mesh = catmull_clark(catmull_clark(_cage()))
    tags = mesh.face_data["tag"]
    mesh.face_data = {"tag": tags % COVERED, "covered": tags // COVERED}
    mesh.vertex_data["color"] = _colors(mesh.positions)
    return mesh


def figure_groups(mesh: QuadMesh) -> dict[str, Ints]:
    """Vertices of the parts that pins and handles take, by name; L is the figure's left, x > 0."""
    x, _, z = mesh.positions.T
    is_head, is_hand = z > 1.20, (np.abs(x) > 0.60) & (z < 0.80)
    masks = {
        "Head": is_head,
        "Hand L": is_hand & (x > 0),
        "Hand R": is_hand & (x < 0),
        "Foot L": (z < 0.13) & (x > 0),
        "Foot R": (z < 0.13) & (x < 0),
    }
    return {name: np.flatnonzero(mask).astype(np.int32) for name, mask in masks.items()}


def _cage() -> QuadMesh:
    cage = Cage()
    rings = []
    for k, ring in enumerate(RINGS):
        cage.weights = {"loose": float(k == HEM)}
        rings.append(cage.half_loop(_half_ring(ring)))
    cage.weights = {"loose": 0.0}
    for k, (lower, upper) in enumerate(pairwise(rings)):
        front, back = _tags(k)
        cage.tag = front
        cage.loft_half(lower[:SIDE], upper[:SIDE])
        cage.tag = back
        cage.loft_half(lower[SIDE - 1 :], upper[SIDE - 1 :])
    cage.tag = SCALP
    cage.cap_half(rings[-1], TOP)
    cage.move(rings[EYES][0], cage.position(rings[EYES][0]) + NOSE)
    _leg(cage, rings[0])
    _arm(cage, cage.open_block(rings, ARM, HALF // 2 - 1)[::-1])
    cage.tag = SKIN
    ear = cage.open_block(rings, EAR, HALF // 2 - 1)[::-1]
    _limb(cage, ear, np.array(EAR_LINE), np.array(EAR_RADII))
    return cage.mirrored()


def _tags(k: int) -> tuple[int, int]:
    """Of the faces above a ring, in front and at the back."""
    if k >= NAPE:
        return (SCALP if k >= CROWN else SKIN), SCALP
    tag = (TROUSERS if k < TROUSERS_END else SKIN) + (COVERED if HEM <= k < COLLAR else 0)
    return tag, tag


def _half_ring(ring: Ring) -> list[tuple[float, float, float]]:
    angles = [pi * i / (HALF - 1) for i in range(HALF)]
    return [(ring.radius_x * sin(a), ring.y - ring.radius_y * cos(a), ring.z) for a in angles]


def _leg(cage: Cage, hips: list[int]) -> None:
    loop = [*hips, *(cage.seam(point) for point in CROTCH)][::-1]
    for k, (x, y, z, radius_x, radius_y) in enumerate(LEG):
        cage.tag = SHOES if k >= SHOE else TROUSERS
        # As the ring of the hips goes: from the front of the seam around the outside.
        points = ellipse((x, y, z), (radius_x, 0, 0), (0, radius_y, 0), n=12, phase=-2 * pi / 3)
        lower = cage.loop(points[::-1])
        cage.loft(loop, lower)
        loop = lower
    x, y, z = LEG[-1][:3]
    cage.cap(loop, (x, y, z - 0.001))


def _arm(cage: Cage, loop: list[int]) -> None:
    line = np.array(ARM_LINE)
    centres, loops = np.insert(line[:, :2], 1, 0.0, axis=1), [loop]
    for k, points in enumerate(rings_along(cage, loop, centres, line[:, 2:], (0.0, -1.0, 0.0))):
        cage.tag = SKIN + (COVERED if k <= SLEEVE else 0)
        cage.weights = {"loose": float(k == SLEEVE)}
        loops.append(cage.loop(points))
        cage.loft(loops[-2], loops[-1])
    cage.weights = {"loose": 0.0}
    cage.cap(loops[-1], centres[-1] + 0.3 * (centres[-1] - centres[-2]))
    loops = loops[1:]
    to_front = [-cage.position(i)[1] for i in loops[HAND]]
    thumb = cage.open_block(loops, HAND, int(np.argmax(to_front)) - 1)[::-1]
    _limb(cage, thumb, np.array(THUMB), np.repeat(np.array(THUMB_RADII), 2).reshape(-1, 2))


def _limb(cage: Cage, loop: list[int], centres: Floats, radii: Floats) -> None:
    """Lofts a thumb or an ear from a hole."""
    for points in rings_along(cage, loop, centres, radii, (0.0, 0.0, 1.0)):
        upper = cage.loop(points)
        cage.loft(loop, upper)
        loop = upper
    cage.cap(loop, centres[-1] + 0.3 * (centres[-1] - centres[-2]))


def _colors(positions: Floats) -> Floats:
    """(n, 3) linear RGB: red cheeks and a red nose."""
    places = np.abs(positions[:, [0]]), positions[:, 1:]
    amount = np.zeros(len(positions))
    for spot, size in ((CHEEK, CHEEK_SIZE), (NOSE_TIP, NOSE_SIZE)):
        distance = np.linalg.norm(np.concatenate(places, axis=1) - spot, axis=1)
        amount += 0.45 * np.exp(-((distance / size) ** 2))
    return np.asarray(COLOR + amount[:, None] * (np.array(BLUSH) - COLOR))
