# SPDX-License-Identifier: GPL-3.0-or-later
"""The cage of the fox cub: all its proportions, and how its parts hang together. It faces -y; lengths are in metres."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import cos, pi, radians, sin
from typing import NamedTuple

import numpy as np

from .cage import Cage, ellipse
from .quad_mesh import Floats, QuadMesh

SKIN, EYE, NOSE = 0, 1, 2


class SpineRing(NamedTuple):
    """A ring of 12 vertices around the spine: centre, pitch in degrees (0: along -y, 90: upwards), half sizes."""

    y: float
    z: float
    pitch: float
    width: float
    up: float
    down: float
    low: float = 0.0  # how far the widest part hangs below the centre


class LegRing(NamedTuple):
    x: float
    y: float
    z: float
    radius_x: float
    radius_y: float
    slope: float = 0.0  # how much higher outwards


class TailRing(NamedTuple):
    y: float
    z: float
    radius: float


class EarRing(NamedTuple):
    height: float
    half_width: float
    depth: float


SPINE = (  # from the rump to the muzzle
    SpineRing(0.480, 0.600, -10, 0.190, 0.170, 0.180),
    SpineRing(0.420, 0.590, -6, 0.270, 0.250, 0.255),
    SpineRing(0.325, 0.585, -2, 0.310, 0.285, 0.280),  # hind legs: this ring and two more
    SpineRing(0.190, 0.578, 0, 0.315, 0.275, 0.290),
    SpineRing(0.050, 0.575, 0, 0.312, 0.260, 0.295),
    SpineRing(-0.045, 0.580, 4, 0.308, 0.252, 0.295),
    SpineRing(-0.125, 0.595, 8, 0.300, 0.250, 0.285),  # front legs
    SpineRing(-0.240, 0.610, 12, 0.290, 0.250, 0.285),
    SpineRing(-0.345, 0.650, 24, 0.275, 0.235, 0.295),
    SpineRing(-0.390, 0.730, 45, 0.255, 0.205, 0.255),
    SpineRing(-0.430, 0.815, 55, 0.255, 0.185, 0.230),  # neck
    SpineRing(-0.455, 0.905, 52, 0.350, 0.270, 0.260),
    SpineRing(-0.490, 1.000, 34, 0.440, 0.360, 0.310),  # ears
    SpineRing(-0.575, 1.060, 13, 0.485, 0.430, 0.345),
    SpineRing(-0.675, 1.075, 2, 0.495, 0.430, 0.355, 0.03),
    SpineRing(-0.780, 1.065, -4, 0.470, 0.390, 0.340, 0.05),  # eyes
    SpineRing(-0.870, 1.035, -10, 0.395, 0.315, 0.290, 0.04),
    SpineRing(-0.930, 0.990, -14, 0.285, 0.200, 0.215),
    SpineRing(-0.985, 0.955, -12, 0.200, 0.125, 0.165),
    SpineRing(-1.050, 0.940, -8, 0.165, 0.100, 0.135),
    SpineRing(-1.095, 0.935, -6, 0.115, 0.080, 0.095),
)
HIND_BLOCK, FRONT_BLOCK = (2, 3), (6, 3)  # ring, place around the ring from the top
EAR_BLOCK, EYE_BLOCK = (12, 1), (15, 2)
FIRST_HEAD_RING, FIRST_SNOUT_RING = 11, 17

NUDGES = {  # (ring, place from the top): a shift of that vertex of the spine's rings
    # The inner edge of the legs' holes goes in and down, under the belly.
    (2, 5): (-0.040, 0.0, -0.005),
    (3, 5): (-0.050, 0.0, -0.010),
    (4, 5): (-0.040, 0.0, -0.005),
    (6, 5): (-0.040, 0.0, -0.005),
    (7, 5): (-0.050, 0.0, -0.010),
    (8, 5): (-0.040, 0.0, -0.005),
    # The throat's corner opens.
    (11, 5): (0.0, 0.010, 0.012),
    (11, 6): (0.0, 0.020, 0.020),
    (12, 6): (0.0, -0.005, 0.015),
    (13, 5): (0.0, -0.025, 0.0),
    (13, 6): (0.0, -0.035, 0.003),
    (14, 5): (0.0, -0.020, 0.0),
    (14, 6): (0.0, -0.030, 0.0),
    # The corners of the mouth go up.
    (20, 4): (0.0, 0.0, -0.018),
    (19, 4): (0.0, 0.0, 0.004),
    (18, 4): (0.005, 0.0, 0.032),
    (18, 3): (0.0, 0.0, 0.012),
    (17, 4): (0.010, 0.0, 0.050),
    (17, 3): (0.0, 0.0, 0.015),
}

FRONT_LEG = (
    LegRing(0.200, -0.265, 0.330, 0.120, 0.128, 0.45),
    LegRing(0.196, -0.262, 0.280, 0.112, 0.118, 0.15),
    LegRing(0.195, -0.260, 0.240, 0.112, 0.114),
    LegRing(0.195, -0.260, 0.190, 0.108, 0.110),
    LegRing(0.195, -0.265, 0.130, 0.112, 0.118),
    LegRing(0.198, -0.285, 0.075, 0.135, 0.155),
    LegRing(0.200, -0.300, 0.020, 0.145, 0.175),
    LegRing(0.200, -0.300, 0.001, 0.112, 0.140),
)
HIND_LEG = (
    LegRing(0.212, 0.185, 0.335, 0.125, 0.150, 0.45),
    LegRing(0.208, 0.192, 0.282, 0.118, 0.138, 0.15),
    LegRing(0.206, 0.205, 0.232, 0.118, 0.126),
    LegRing(0.206, 0.215, 0.180, 0.110, 0.114),
    LegRing(0.206, 0.210, 0.125, 0.112, 0.118),
    LegRing(0.208, 0.190, 0.075, 0.135, 0.155),
    LegRing(0.210, 0.175, 0.020, 0.145, 0.175),
    LegRing(0.210, 0.175, 0.001, 0.112, 0.140),
)

TAIL = (
    TailRing(0.545, 0.665, 0.100),
    TailRing(0.635, 0.705, 0.110),
    TailRing(0.740, 0.770, 0.140),
    TailRing(0.845, 0.865, 0.175),
    TailRing(0.920, 0.985, 0.205),
    TailRing(0.950, 1.120, 0.215),
    TailRing(0.935, 1.260, 0.200),
    TailRing(0.880, 1.385, 0.160),
    TailRing(0.800, 1.475, 0.100),
    TailRing(0.745, 1.520, 0.045),
)

HEAD_CENTRE = np.array([0.0, -0.630, 1.070])
HEAD_RADII = np.array([0.500, 0.450, 0.440])

EAR_BASE = np.array([0.295, -0.600, 1.340])
EAR_AXIS = np.array([0.40, 0.14, 0.90])
EAR_FACE = np.array([0.38, -0.92, 0.0])  # where the hollow looks
EAR = (
    EarRing(0.09, 0.140, 0.100),
    EarRing(0.15, 0.180, 0.108),
    EarRing(0.23, 0.200, 0.095),
    EarRing(0.33, 0.175, 0.075),
    EarRing(0.42, 0.120, 0.055),
    EarRing(0.49, 0.055, 0.030),
)
# The ear's section: sideways and forwards, from the hollow's middle around; the hollow is places 7, 0, 1.
EAR_SECTION = (
    (0.0, -0.15), (0.60, 0.45), (1.0, 0.35), (0.75, -0.55), (0.0, -1.0), (-0.75, -0.55), (-1.0, 0.35), (-0.60, 0.45),
)  # fmt: skip

EYE_CENTRE = np.array([0.300, -0.850, 1.075])
EYE_NORMAL = np.array([0.52, -0.84, 0.12])
EYE_RADIUS = 0.105
EYE_RINGS = ((1.12, 0.012, SKIN), (0.98, -0.012, SKIN), (0.95, 0.020, EYE), (0.60, 0.050, EYE))  # radius, height, what


def creature_cage() -> QuadMesh:
    """The whole cage, 776 quads.

    Face data "tag" is SKIN, EYE or NOSE. Vertex data are 1 on "head", "snout" and "leg", 1 in the hollow of the ears
    ("inner"), and grow towards the tip along "ear" and "tail". The paths "mouth" and "mouth_mirror" run from below the
    nose to the corners.
    """
    cage = Cage()
    rings = _spine(cage)
    _leg(cage, cage.open_block(rings, *HIND_BLOCK), HIND_LEG)
    _leg(cage, cage.open_block(rings, *FRONT_BLOCK), FRONT_LEG)
    _ear(cage, cage.open_block(rings, *EAR_BLOCK))
    _eye(cage, cage.open_block(rings, *EYE_BLOCK))
    _tail(cage, rings[0])
    _muzzle(cage, rings)
    return cage.mirrored()


def _spine(cage: Cage) -> list[list[int]]:
    """Half rings from the top to the bottom, seven vertices each."""
    rings = []
    for k, ring in enumerate(SPINE):
        cage.weights = {"head": float(k >= FIRST_HEAD_RING), "snout": float(k >= FIRST_SNOUT_RING)}
        rings.append(cage.half_loop(_spine_points(ring)))
    for (k, j), lift in NUDGES.items():
        cage.move(rings[k][j], cage.position(rings[k][j]) + lift)
    for back, front in pairwise(rings):
        cage.loft_half(back[::-1], front[::-1])
    return rings


def _spine_points(ring: SpineRing) -> list[tuple[float, float, float]]:
    pitch = radians(ring.pitch)
    points = []
    for j in range(7):
        a = pi * j / 6
        height = cos(a) * (ring.up if j < 3 else ring.down) - ring.low * sin(a)
        points.append((ring.width * sin(a), ring.y + height * sin(pitch), ring.z + height * cos(pitch)))
    return points


def _leg(cage: Cage, loop: list[int], rings: Sequence[LegRing]) -> None:
    cage.weights = {"leg": 1.0}
    for ring in rings:
        centre = (ring.x, ring.y, ring.z)
        # The block's loop starts outside at the back and goes on forwards.
        points = ellipse(centre, (ring.radius_x, 0, ring.radius_x * ring.slope), (0, -ring.radius_y, 0), phase=-pi / 4)
        upper = cage.loop(points)
        cage.loft(loop, upper)
        loop = upper
    last = rings[-1]
    cage.cap(loop, (last.x, last.y, last.z - 0.001))


def _tail(cage: Cage, rump: list[int]) -> None:
    """Closes the rump: the tail's root above, four quads below."""
    back = SPINE[0]
    cage.weights = {}
    root = cage.seam((0, back.y + 0.03, back.z - 0.01))
    seat = cage.seam((0, back.y + 0.03, back.z - 0.10))
    cage.quad(root, rump[3], rump[4], seat)
    cage.quad(seat, rump[4], rump[5], rump[6])

    tangents = np.gradient(np.array([(ring.y, ring.z) for ring in TAIL]), axis=0)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    loop = [*rump[:4], root]
    for k, (ring, (ty, tz)) in enumerate(zip(TAIL, tangents, strict=True)):
        cage.weights = {"tail": (k + 1) / len(TAIL)}
        points = ellipse((0, ring.y, ring.z), (0, -ring.radius * tz, ring.radius * ty), (ring.radius, 0, 0))
        upper = cage.half_loop(points[:5])
        cage.loft_half(loop, upper)
        loop = upper
    cage.cap_half(loop, (0, TAIL[-1].y + 0.015 * tangents[-1][0], TAIL[-1].z + 0.015 * tangents[-1][1]))


def _muzzle(cage: Cage, rings: list[list[int]]) -> None:
    """Closes the muzzle: a nose button above, the chin below, the mouth between."""
    ring, front = rings[-1], SPINE[-1]
    cage.weights = {"head": 1.0, "snout": 1.0}
    below_nose = cage.seam((0, front.y - 0.03, front.z - 0.022))
    lip = cage.seam((0, front.y - 0.03, front.z - 0.06))
    cage.quad(below_nose, lip, ring[4], ring[3])
    cage.quad(lip, ring[6], ring[5], ring[4])
    cage.path("mouth", [below_nose, lip, *(rings[-k][4] for k in (1, 2, 3, 4))])

    loop = [below_nose, ring[3], ring[2], ring[1], ring[0]]
    for size, out in ((0.95, -0.01), (1.0, 0.015), (0.62, 0.042)):
        y, z = front.y - 0.02 - out, front.z + 0.035
        side = [(size * x, y, z + size * dz) for x, dz in ((0.062, -0.022), (0.088, 0.022), (0.055, 0.055))]
        upper = cage.half_loop([(0, y, z - 0.035 * size), *side, (0, y + 0.01, z + size * 0.06)])
        cage.loft_half(loop, upper)
        loop = upper
        cage.tag = NOSE
    cage.cap_half(loop, (0, front.y - 0.072, front.z + 0.042))
    cage.tag = SKIN


def _ear(cage: Cage, loop: list[int]) -> None:
    axis = EAR_AXIS / np.linalg.norm(EAR_AXIS)
    face = _unit(EAR_FACE - axis * (EAR_FACE @ axis))
    side = np.cross(axis, face)
    places = _ear_places(cage, loop, side, face)
    around = [EAR_BASE + 0.225 * s * side + (0.165 * f + 0.015) * face for s, f in _section(places)]
    _gather_on_head(cage, loop, around)
    for k, ring in enumerate(EAR):
        upper = []
        for place, (s, f) in zip(places, _section(places), strict=True):
            in_hollow = place in (7, 0, 1) and k < len(EAR) - 1
            cage.weights = {"head": 1.0, "ear": (k + 1) / len(EAR), "inner": float(in_hollow)}
            offset = axis * ring.height + side * ring.half_width * s + face * ring.depth * f
            upper.append(cage.vertex(EAR_BASE + offset))
        cage.loft(loop, upper)
        loop = upper
    cage.cap(loop, EAR_BASE + axis * (EAR[-1].height + 0.01))


def _ear_places(cage: Cage, loop: list[int], side: Floats, face: Floats) -> list[int]:
    """The place in the ear's section of each vertex around the hole: the foremost is the hollow's middle."""
    points = np.array([cage.position(i) for i in loop])
    offsets = points - points.mean(axis=0)
    angles = np.arctan2(offsets @ side, offsets @ face)
    start = int(np.argmin(np.abs(angles)))
    turn = 1 if np.sin(angles[(start + 1) % 8]) > 0 else -1
    return [turn * (i - start) % 8 for i in range(8)]


def _section(places: list[int]) -> list[tuple[float, float]]:
    return [EAR_SECTION[place] for place in places]


def _gather_on_head(cage: Cage, loop: list[int], targets: list[Floats]) -> None:
    """Draws the vertices around a hole towards ``targets``, along the head's ellipsoid."""
    normal = _normal(cage, loop)
    for i, target in zip(loop, targets, strict=True):
        way = target - cage.position(i)
        moved = cage.position(i) + 0.85 * (way - normal * (way @ normal))
        cage.move(i, HEAD_CENTRE + HEAD_RADII * _unit((moved - HEAD_CENTRE) / HEAD_RADII))


def _eye(cage: Cage, loop: list[int]) -> None:
    normal = _unit(EYE_NORMAL)
    up = _unit(np.array([0.0, 0.0, 1.0]) - normal * normal[2])
    right: Floats = np.asarray(np.cross(up, normal), dtype=np.float64)
    offsets = np.array([cage.position(i) for i in loop]) - EYE_CENTRE
    angles = np.arctan2(offsets @ up, offsets @ right)
    # The turn that fits the hole's vertices best, so that the rings do not twist.
    phase = float(np.angle(np.exp(1j * (angles - pi / 4 * np.arange(8))).sum()))

    def ring(radius: float, height: float) -> list[Floats]:
        r = radius * EYE_RADIUS
        return ellipse(EYE_CENTRE + normal * height, r * right, 1.12 * r * up, phase=phase)

    for i, target in zip(loop, ring(1.55, -0.03), strict=True):
        way = target - cage.position(i)
        out = normal * (way @ normal)
        cage.move(i, cage.position(i) + 0.7 * (way - out) + 0.25 * out)
    cage.weights = {"head": 1.0}
    for radius, height, cage.tag in EYE_RINGS:
        upper = cage.loop(ring(radius, height))
        cage.loft(loop, upper)
        loop = upper
    cage.cap(loop, EYE_CENTRE + normal * 0.058)
    cage.tag = SKIN


def _normal(cage: Cage, loop: list[int]) -> Floats:
    points = np.array([cage.position(i) for i in loop])
    offsets = points - points.mean(axis=0)
    return _unit(np.cross(offsets, np.roll(offsets, -1, axis=0)).sum(axis=0))


def _unit(vector: Floats) -> Floats:
    return np.asarray(vector / np.linalg.norm(vector), dtype=np.float64)
