# SPDX-License-Identifier: GPL-3.0-or-later
"""What the figure wears: a shirt, which is an open sheet, a belt, and buttons with a buckle; needs numpy alone."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin

import numpy as np

from .cage import Cage, ellipse
from .quad_mesh import Floats, Ints, QuadMesh, edges_of, vertex_normals
from .subdivision import catmull_clark

GAP, LOOSE = 0.012, 0.016  # of the shirt from the body: everywhere, and more at its edges
SMOOTHINGS = 40

BELT_HEIGHT, BELT_Z = 0.060, 0.745
BELT_GAP, BELT_THICK = 0.020, 0.014  # from the body
N_AROUND = 64

BUTTON_HEIGHTS, BUTTON_GAP = (0.82, 0.89, 0.96), 0.013
BUTTON = ((0.021, 0.0), (0.023, 0.005), (0.021, 0.010), (0.013, 0.010), (0.010, 0.007))  # radius, height
BUCKLE = (0.056, 0.044, 0.014)  # half width, half height, thickness


def shirt(body: QuadMesh) -> QuadMesh:
    """The body's faces under it, moved outwards; open at the neck, the sleeves and the hem."""
    under, numbers = np.unique(body.quads[body.face_data["covered"] == 1], return_inverse=True)
    quads = numbers.reshape(-1, 4).astype(np.int32)
    skin, normals = body.positions[under], vertex_normals(body)[under]
    gap = GAP + LOOSE * body.vertex_data["loose"][under]
    positions = skin + gap * normals
    edges, side_edge = edges_of(quads)
    is_inner = np.ones(len(under), dtype=bool)
    is_inner[edges[np.bincount(side_edge.ravel()) == 1]] = False
    for _ in range(SMOOTHINGS):  # or it would cross itself in the armpits
        positions[is_inner] = _neighbour_means(positions, edges)[is_inner]
        positions += np.maximum(0.0, gap - ((positions - skin) * normals).sum(axis=1, keepdims=True)) * normals
    return QuadMesh(positions, quads)


def _neighbour_means(positions: Floats, edges: Ints) -> Floats:
    """Of each vertex its neighbours' mean, (n, 3)."""
    sums, ends = np.zeros_like(positions), np.concatenate([edges, edges[:, ::-1]])
    np.add.at(sums, ends[:, 0], positions[ends[:, 1]])
    return np.asarray(sums / np.bincount(ends[:, 0])[:, None])


def belt(body: QuadMesh) -> QuadMesh:
    """A closed band around the waist."""
    angles = 2 * pi * np.arange(N_AROUND) / N_AROUND
    half = BELT_HEIGHT / 2
    sides = ((BELT_GAP, -half), (BELT_GAP + BELT_THICK, -half), (BELT_GAP + BELT_THICK, half), (BELT_GAP, half))
    cage = Cage()
    loops = [cage.loop(list(waist(body, BELT_Z + dz, angles, gap))) for gap, dz in sides]
    for lower, upper in pairwise([*loops, loops[0]]):
        cage.loft(lower, upper)
    return catmull_clark(cage.whole())


def buttons(body: QuadMesh) -> QuadMesh:
    """Three buttons down the chest and a buckle; face data "tag" is 0 for buttons, 1 for the buckle."""
    cage = Cage()
    for z in BUTTON_HEIGHTS:
        front = waist(body, z, np.array([-pi / 2]), GAP)[0]
        loops = [
            cage.loop(ellipse(front - [0.0, height, 0.0], (radius, 0, 0), (0, 0, radius))) for radius, height in BUTTON
        ]
        _close(cage, loops)
    cage.tag = 1
    front = waist(body, BELT_Z, np.array([-pi / 2]), BELT_GAP + 0.4 * BELT_THICK)[0]
    rows = (1.0, 0.0), (1.06, 0.4), (1.0, 1.0), (0.66, 1.0), (0.58, 0.78), (0.3, 0.75)  # size, height
    width, height, thick = BUCKLE
    loops = [
        cage.loop([front + np.array([width * size * x, -thick * out, height * size * z]) for x, z in _square()])
        for size, out in rows
    ]
    _close(cage, loops)
    return catmull_clark(cage.whole())


def waist(body: QuadMesh, z: float, angles: Floats, gap: float) -> Floats:
    """(n, 3) places around the trunk at a height, ``gap`` away from it."""
    x, _, height = body.positions.T
    is_trunk = (np.abs(height - z) < 0.05) & (np.abs(x) < 0.23)
    x, y, height = body.positions[is_trunk].T
    turns = np.arctan2(y, x)
    turn = np.abs((angles[:, None] - turns + pi) % (2 * pi) - pi)
    weights = np.exp(-((turn / 0.05) ** 2) - ((height - z) / 0.02) ** 2)
    reach = weights @ np.hypot(x, y) / weights.sum(axis=1) + gap
    return np.stack([reach * np.cos(angles), reach * np.sin(angles), np.full(len(angles), z)], axis=1)


def _square() -> list[tuple[float, float]]:
    """Eight places around a square, counter-clockwise."""
    return [(np.clip(1.42 * cos(a), -1, 1), np.clip(1.42 * sin(a), -1, 1)) for a in 2 * pi * np.arange(8) / 8]


def _close(cage: Cage, loops: list[list[int]]) -> None:
    """Lofts loops, the first one at the back, and closes both ends."""
    for lower, upper in pairwise(loops):
        cage.loft(lower, upper)
    back, front = (np.mean([cage.position(i) for i in loop], axis=0) for loop in (loops[0], loops[-1]))
    cage.cap(loops[0][::-1], back)
    cage.cap(loops[-1], front)
