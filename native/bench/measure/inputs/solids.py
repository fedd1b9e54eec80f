# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces made from numbers, and the same surfaces cut otherwise: (n, 3) positions and (f, 3) triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .mesh import Floats, Ints, Mask, Mesh, cut_quads, midpoint_subdivision, unscaled

Surface = tuple[Floats, Ints]


def sheet(size: tuple[float, float], cells: tuple[int, int]) -> Surface:
    """A rectangle in z = 0, from x = 0 and about y = 0."""
    nx, ny = cells
    i, j = np.meshgrid(np.arange(nx + 1), np.arange(ny + 1), indexing="ij")
    positions = np.stack([i / nx * size[0], (j / ny - 0.5) * size[1], 0.0 * i], axis=-1).reshape(-1, 3)
    corner = (i * (ny + 1) + j)[:-1, :-1].ravel()
    return positions, cut_quads(np.stack([corner, corner + ny + 1, corner + ny + 2, corner + 1], axis=1))


def plate(size: tuple[float, float, float], cells: tuple[int, int]) -> Surface:
    """A closed plate in x > 0, its middle plane z = 0: mirror-symmetric in z, one cell thick."""
    flat, upper = sheet(size[:2], cells)
    n, half = len(flat), np.array([0.0, 0.0, 0.5 * size[2]])
    at = np.arange(n).reshape(cells[0] + 1, cells[1] + 1)
    border = np.concatenate([at[:-1, 0], at[-1, :-1], at[:0:-1, -1], at[0, :0:-1]])
    after = np.roll(border, -1)
    rim = cut_quads(np.stack([border + n, after + n, after, border], axis=1))
    return np.concatenate([flat + half, flat - half]), np.concatenate([upper, upper[:, [0, 2, 1]] + n, rim])


def cubes(is_solid: NDArray[np.bool_], side: float = 1.0) -> Surface:
    """The surface between those cubes of a grid that are solid and the others."""
    places, quads = cube_quads(is_solid)
    return side * places, cut_quads(quads)


def cube_quads(is_solid: NDArray[np.bool_]) -> Surface:
    """The same surface in quads (f, 4), of cubes of side 1."""
    padded = np.pad(is_solid, 1)
    quads = []
    for axis in range(3):
        u, v = np.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
        steps = np.diff(padded.astype(np.int8), axis=axis)  # 1 where it begins along the axis, -1 where it ends
        for step, around in ((-1, (0 * u, u, u + v, v)), (1, (0 * u, v, u + v, u))):
            # Of the padded grid, cube k lies between the corners k - 1 and k.
            first = np.argwhere(steps == step) - (1 - np.eye(3, dtype=int)[axis])
            quads.append(np.stack([first + offset for offset in around], axis=1))
    corners = np.concatenate(quads)
    places, vertices = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return places.astype(np.float64), vertices.reshape(-1, 4).astype(np.int32)


def joined(*surfaces: Surface) -> Surface:
    """One after the other, as parts of one mesh."""
    starts = np.cumsum([0, *(len(positions) for positions, _ in surfaces)])
    faces = [triangles + start for (_, triangles), start in zip(surfaces, starts, strict=False)]
    return np.concatenate([positions for positions, _ in surfaces]), np.concatenate(faces).astype(np.int32)


def welded(surface: Surface, tolerance: float = 1e-9) -> Surface:
    """With one vertex where there were several at the same place."""
    positions, triangles = surface
    _, first, vertex = np.unique(np.rint(positions / tolerance), axis=0, return_index=True, return_inverse=True)
    return positions[first], vertex.reshape(-1)[triangles].astype(np.int32)


def cut_apart(mesh: Mesh, gap: float) -> Mesh:
    """A polygon soup: each triangle by itself, and smaller by a share about its middle. Old corners in their order."""
    corners = mesh.positions[mesh.triangles]
    middles = corners.mean(axis=1, keepdims=True)
    places = (middles + (1.0 - gap) * (corners - middles)).reshape(-1, 3)
    return unscaled(mesh.name, places, np.arange(len(places)).reshape(-1, 3))


def with_needles(mesh: Mesh, faces: Ints, height: float) -> Mesh:
    """Cuts triangles in three at a point next to the middle of a side, ``height`` of the side from it."""
    a, b, c = mesh.triangles[faces].T
    p = mesh.positions
    new = ((0.5 - 0.5 * height) * (p[a] + p[b]) + height * p[c]).reshape(-1, 3)
    middle = len(p) + np.arange(len(faces))
    cut = [np.stack(corners, axis=1) for corners in ((a, b, middle), (b, c, middle), (c, a, middle))]
    whole = np.delete(mesh.triangles, faces, axis=0)
    return unscaled(mesh.name, np.concatenate([p, new]), np.concatenate([whole, *cut]))


def finer_where(mesh: Mesh, is_chosen: Mask) -> Mesh:
    """Cuts the chosen triangles in four, and their neighbours so that no vertex is on a side; old vertices first."""
    fine = midpoint_subdivision(mesh)
    quarters = fine.triangles.reshape(-1, 4, 3)
    middles = quarters[:, 3]  # of the sides from corner k to the next
    is_cut = np.zeros(len(fine.positions), dtype=bool)
    is_cut[middles[is_chosen]] = True
    faces = [quarters[is_cut[middles].all(axis=1)].reshape(-1, 3), mesh.triangles[~is_cut[middles].any(axis=1)]]
    for k in range(3):
        corners, sides = (np.roll(of_face, -k, axis=1) for of_face in (mesh.triangles, middles))
        is_side = is_cut[sides]
        one, two = (np.all(is_side == pattern, axis=1) for pattern in ((True, False, False), (True, True, False)))
        (a, b, c), m = corners[one].T, sides[one, 0]
        faces += [np.stack([a, m, c], axis=1), np.stack([m, b, c], axis=1)]
        (a, b, c), (m, n) = corners[two].T, sides[two, :2].T
        faces += [np.stack(triangle, axis=1) for triangle in ((a, m, c), (m, n, c), (m, b, n))]
    used = np.concatenate(
        [np.arange(len(mesh.positions)), len(mesh.positions) + np.flatnonzero(is_cut[len(mesh.positions) :])]
    )
    number = np.full(len(fine.positions), -1)
    number[used] = np.arange(len(used))
    return unscaled(mesh.name, fine.positions[used], number[np.concatenate(faces)])


def rod(length: float, around: int, along: int, cap_rings: int = 6) -> Surface:
    """A closed cylinder of diameter 1 about z, its middle at the origin; diagonals go to and fro, so it has no hand."""
    angles = 2 * np.pi * np.arange(around) / around
    circle = 0.5 * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1)
    heights = length * (np.arange(along + 1) / along - 0.5)
    inner = np.arange(1, cap_rings) / cap_rings
    up, side = np.array([0.0, 0.0, 0.5 * length]), np.array([1.0, 1.0, 0.0])
    low = [circle * share * side - up for share in inner]
    rings = low + [circle + np.array([0.0, 0.0, z]) for z in heights] + [ring * side + up for ring in low[::-1]]
    n, first = len(rings), np.arange(around)
    at = np.arange(n * around).reshape(n, around)
    a, b = at[:-1], np.roll(at[:-1], -1, axis=1)
    quads = np.stack([a, b, b + around, a + around], axis=-1)
    is_odd = (np.add.outer(np.arange(n - 1), first) % 2).astype(bool)
    quads[is_odd] = np.roll(quads[is_odd], 1, axis=1)
    ends, bottom, top = np.stack([-up, up]), n * around, n * around + 1
    fans = [
        np.stack([np.roll(at[0], -1), at[0], np.full(around, bottom)], axis=1),
        np.stack([at[-1], np.roll(at[-1], -1), np.full(around, top)], axis=1),
    ]
    faces = np.concatenate([cut_quads(quads.reshape(-1, 4)), *fans]).astype(np.int32)
    return np.concatenate([*rings, ends]), faces
