# SPDX-License-Identifier: GPL-3.0-or-later
"""Small meshes as the arrays that arap_native takes."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Mesh(NamedTuple):
    positions: NDArray[np.float64]
    corner_vertices: NDArray[np.int32]
    face_sizes: NDArray[np.int32]

    @property
    def diagonal(self) -> float:
        return float(np.linalg.norm(np.ptp(self.positions, axis=0)))


def tube(rings: int = 12, segments: int = 8) -> Mesh:
    """A closed tube along z, from 0 to 4: quads around, an n-gon at each end."""
    angle = np.arange(segments) * (2 * np.pi / segments)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(segments)]) * 0.5
    height = np.linspace(0.0, 4.0, rings)
    positions = (ring[None, :, :] + height[:, None, None] * np.array([0.0, 0.0, 1.0])).reshape(-1, 3)

    i, j = np.meshgrid(np.arange(rings - 1), np.arange(segments), indexing="ij")
    right = (j + 1) % segments
    quads = np.stack([i, i, i + 1, i + 1], axis=-1) * segments + np.stack([j, right, right, j], axis=-1)
    bottom = np.arange(segments)[::-1]
    top = np.arange(segments) + (rings - 1) * segments
    corners = np.concatenate([quads.ravel(), bottom, top]).astype(np.int32)
    sizes = np.array([4] * ((rings - 1) * segments) + [segments, segments], np.int32)
    return Mesh(np.ascontiguousarray(positions), corners, sizes)


def sheet(n: int) -> Mesh:
    """A square of quads, two units wide about the origin in z = 0; n x n vertices, along x first."""
    line = np.linspace(-1.0, 1.0, n)
    positions = np.stack([*np.meshgrid(line, line), np.zeros((n, n))], axis=-1).reshape(-1, 3)
    first = np.arange(n * n).reshape(n, n)[:-1, :-1].reshape(-1, 1)
    return Mesh(positions, np.add(first, (0, 1, n + 1, n)).ravel().astype(np.int32), np.full(len(first), 4, np.int32))


def ball(centre: tuple[float, ...], radius: float, rings: int = 8, segments: int = 12) -> Mesh:
    """A closed ball of quads, an n-gon at each end."""
    positions, corners, sizes = tube(rings, segments)
    angle = np.pi * (np.repeat(np.arange(rings), segments) + 0.5) / rings
    around = positions[:, :2] / 0.5 * np.sin(angle)[:, None]
    return Mesh(np.column_stack([around, -np.cos(angle)]) * radius + centre, corners, sizes)


def joined(*meshes: Mesh) -> Mesh:
    """All in one mesh, one after the other."""
    firsts = np.cumsum([0, *(len(mesh.positions) for mesh in meshes)])
    return Mesh(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([mesh.corner_vertices + n for mesh, n in zip(meshes, firsts, strict=False)]).astype(np.int32),
        np.concatenate([mesh.face_sizes for mesh in meshes]),
    )


def ends(mesh: Mesh) -> NDArray[np.int32]:
    """The vertices of a tube's two end rings, the lower one first."""
    z = mesh.positions[:, 2]
    return np.concatenate([np.flatnonzero(z == 0.0), np.flatnonzero(z == 4.0)]).astype(np.int32)


def rotation_z(angle_rad: float) -> NDArray[np.float64]:
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def motion(
    linear: NDArray[np.float64] | None = None, shift: tuple[float, ...] = (0.0, 0.0, 0.0)
) -> NDArray[np.float64]:
    """(4, 4) x -> linear x + shift."""
    matrix = np.eye(4)
    matrix[:3, :3] = np.eye(3) if linear is None else linear
    matrix[:3, 3] = shift
    return matrix


def twisted_ends(mesh: Mesh, angle_rad: float = 1.0) -> NDArray[np.float64]:
    """Targets for ends(): the lower ring at rest, the upper one turned about z."""
    targets = mesh.positions[ends(mesh)]
    half = len(targets) // 2
    targets[half:] = targets[half:] @ rotation_z(angle_rad).T
    return targets
