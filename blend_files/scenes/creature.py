# SPDX-License-Identifier: GPL-3.0-or-later
"""The fox cub as arrays: all quads, closed, exactly mirror-symmetric in x, coloured; needs numpy alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .creature_cage import FRONT_LEG, HIND_LEG, LegRing, creature_cage
from .quad_mesh import Floats, Ints, QuadMesh, vertex_normals
from .subdivision import catmull_clark, split_by_three

DEFAULT_VERTICES = 12_418

FUR = (0.78, 0.27, 0.06)
CREAM = (0.93, 0.80, 0.62)
SOCKS = (0.13, 0.055, 0.035)
PINK = (0.88, 0.42, 0.34)

# Under each paw, from its middle, forwards negative: x, y, half sizes.
PADS = (
    (0.0, 0.045, 0.062, 0.050),
    (-0.065, -0.050, 0.026, 0.032),
    (0.0, -0.085, 0.028, 0.034),
    (0.065, -0.050, 0.026, 0.032),
)


def creature(n_vertices: int = DEFAULT_VERTICES) -> QuadMesh:
    """The fox cub with about ``n_vertices``: the nearest of 12 418 times products of 4 and 9.

    It faces -y, stands on z = 0 and is 1.8 m high. Vertex data "color" is linear RGB in [0, 1], (n, 3); see
    ``creature_cage`` for the others and for face data "tag".
    """
    mesh = catmull_clark(catmull_clark(creature_cage()))
    _add_details(mesh)
    twos, threes = _splits(n_vertices / len(mesh.positions))
    for _ in range(threes):
        mesh = split_by_three(mesh)
    for _ in range(twos):
        mesh = catmull_clark(mesh)
    return mesh


def creature_arrays(n_vertices: int = DEFAULT_VERTICES) -> tuple[Floats, Ints, Ints]:
    """rest_positions (n, 3) float64, corner_vertices (c,) int32, face_sizes (f,) int32: what the solver takes."""
    mesh = creature(n_vertices)
    return mesh.positions, mesh.quads.ravel(), np.full(len(mesh.quads), 4, dtype=np.int32)


def creature_groups(mesh: QuadMesh) -> dict[str, Ints]:
    """Vertices of the parts that pins and handles take, by name; L is the creature's left, x > 0."""
    x, y, z = mesh.positions.T
    data = {name: values[:, 0] for name, values in mesh.vertex_data.items()}
    paw = (data["leg"] > 0.5) & (z < 0.10)
    ear = data["ear"] > 0.55
    masks = {
        "Head": (data["head"] > 0.9) & (data["ear"] < 0.02) & (y < -0.62),
        "Tail": data["tail"] > 0.75,
        "Paw front L": paw & (x > 0) & (y < 0),
        "Paw front R": paw & (x < 0) & (y < 0),
        "Paw hind L": paw & (x > 0) & (y > 0),
        "Paw hind R": paw & (x < 0) & (y > 0),
        "Ear L": ear & (x > 0),
        "Ear R": ear & (x < 0),
    }
    return {name: np.flatnonzero(mask).astype(np.int32) for name, mask in masks.items()}


def _splits(factor: float) -> tuple[int, int]:
    """How often to split by two and by three for about ``factor`` times the vertices."""
    plans = [(twos, threes) for twos in range(6) for threes in range(4)]
    return min(plans, key=lambda plan: abs(np.log(4.0 ** plan[0] * 9.0 ** plan[1] / factor)))


def _add_details(mesh: QuadMesh) -> None:
    """Toes, the mouth and the colours, at the size of the second level's edges."""
    for leg in (FRONT_LEG, HIND_LEG):
        _carve_toes(mesh, leg[-2])
    normals = vertex_normals(mesh)
    mouth = np.zeros(len(mesh.positions))
    for path in mesh.paths.values():
        fade = np.clip((len(path) - 1 - np.arange(len(path))) / 3.0, 0.0, 1.0)
        mouth[path] = np.maximum(mouth[path], fade)
    mesh.positions -= normals * (0.012 * mouth)[:, None]
    mesh.vertex_data["color"] = _colors(mesh, normals, mouth)


def _pads(mesh: QuadMesh, paw: LegRing) -> Floats:
    """(n,) 1 on the pads under two of the paws, soft at their edges."""
    x, y, z = np.abs(mesh.positions[:, 0]), mesh.positions[:, 1], mesh.positions[:, 2]
    amount: Floats = np.zeros(len(x))
    for px, py, rx, ry in PADS:
        distance = np.hypot((x - paw.x - px) / rx, (y - paw.y - py) / ry)
        amount = np.maximum(amount, _step(1.35, 0.75, distance))
    return amount * (z < 0.012)


def _carve_toes(mesh: QuadMesh, paw: LegRing) -> None:
    """Two grooves down the front of each of two paws."""
    x, y, z = mesh.positions.T
    dx, dy = (np.abs(x) - paw.x) / paw.radius_x, (y - paw.y) / paw.radius_y
    distance = np.hypot(dx, dy)
    angle = np.degrees(np.arctan2(dx, -dy))
    depth = 0.016 * np.exp(-(((np.abs(angle) - 22.5) / 7.0) ** 2))
    depth *= _step(0.125, 0.07, z) * _step(0.0, 0.02, z) * _step(0.3, 0.7, distance)
    depth *= (mesh.vertex_data["leg"][:, 0] > 0.5) & (distance < 1.5)
    out = np.stack([np.sign(x) * dx * paw.radius_x, dy * paw.radius_y, np.zeros_like(z)], axis=1)
    length = np.maximum(np.linalg.norm(out, axis=1), 1e-9)
    mesh.positions -= out * (depth / length)[:, None]


def _colors(mesh: QuadMesh, normals: Floats, mouth: Floats) -> Floats:
    """(n, 3) linear RGB: fur, and over it the markings."""
    x, y, z = np.abs(mesh.positions[:, 0]), mesh.positions[:, 1], mesh.positions[:, 2]
    part = {name: values[:, 0] for name, values in mesh.vertex_data.items()}
    body = (1 - part["head"]) * (1 - part["leg"]) * (part["tail"] < 0.02)
    belly = body * _step(-0.35, -0.75, normals[:, 2])
    chest = body * _step(-0.20, -0.50, normals[:, 1]) * _step(0.24, 0.12, x) * _step(0.94, 0.86, z) * (z > 0.3)
    # Cheeks and muzzle: below a line that rises to the sides, and not behind the cheek's tuft.
    line = 0.985 + 0.10 * _step(0.10, 0.42, x)
    tuft = -0.52 - 0.9 * np.abs(z - 0.93)
    cheek = part["head"] * (part["ear"] < 0.05) * _step(line + 0.03, line - 0.03, z) * _step(tuft, tuft - 0.08, y)
    markings = (
        (np.maximum(belly, chest), CREAM),
        (cheek, CREAM),
        (_step(0.70, 0.80, part["tail"]), CREAM),
        (_step(0.19, 0.14, z) * (part["leg"] > 0.5), SOCKS),
        (_pads(mesh, FRONT_LEG[-2]) + _pads(mesh, HIND_LEG[-2]), PINK),
        (_step(0.72, 0.86, part["ear"]), SOCKS),
        (_step(0.45, 0.70, part["inner"]), PINK),
        (0.8 * mouth, SOCKS),
    )
    color = np.tile(np.array(FUR), (len(x), 1))
    for amount, tint in markings:
        color += amount[:, None] * (np.array(tint) - color)
    return color


def _step(low: NDArray[np.float64] | float, high: NDArray[np.float64] | float, x: Floats) -> Floats:
    """0 at low, 1 at high (which may be smaller), smooth between."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)
