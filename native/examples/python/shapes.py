# SPDX-License-Identifier: GPL-3.0-or-later
"""What the examples share: a mesh made on the spot, its volume, a turn, and an OBJ file."""

from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Faces = list[list[int]]


def tube(rings: int = 61, around: int = 24) -> tuple[Floats, Faces]:
    """Returns positions and faces of a closed tube from x = 0 to 6, of radius 0.5: quads, and a polygon at each end."""
    x, angle = np.meshgrid(np.linspace(0.0, 6.0, rings), np.arange(around) * 2 * np.pi / around, indexing="ij")
    positions = np.stack([x, 0.5 * np.cos(angle), 0.5 * np.sin(angle)], axis=-1).reshape(-1, 3)
    ring = np.arange(rings * around).reshape(rings, around)
    beside = np.roll(ring, -1, axis=1)
    quads = np.stack([ring[:-1], beside[:-1], beside[1:], ring[1:]], axis=-1).reshape(-1, 4)
    return positions, [*quads.tolist(), ring[0, ::-1].tolist(), ring[-1].tolist()]


def volume(positions: Floats, faces: Faces) -> float:
    """Returns the volume inside of faces that are oriented outwards."""
    triangles = np.array([(face[0], *pair) for face in faces for pair in pairwise(face[1:])])
    return float(np.linalg.det(positions[triangles]).sum() / 6)


def turn(degrees: float, axis: str) -> Floats:
    """Returns the (3, 3) rotation about an axis, "x", "y" or "z"."""
    cos, sin = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    about_z = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    first = "zxy".index(axis)
    return np.roll(about_z, (first, first), axis=(0, 1))


def write_obj(path: str, positions: Floats, faces: Faces) -> None:
    """Writes a mesh to a file that any 3D program opens."""
    lines = [f"v {x:.6f} {y:.6f} {z:.6f}" for x, y, z in positions.tolist()]
    lines += ["f " + " ".join(str(vertex + 1) for vertex in face) for face in faces]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")
