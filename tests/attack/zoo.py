# SPDX-License-Identifier: GPL-3.0-or-later
"""Bad meshes of any size, each kind a maker of about ``n`` vertices, for what attacks the module.

A kind is bad in one way: degenerate, non-manifold, far too large or small, thousands of corners in one place. KINDS has
them all by name.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Positions = NDArray[np.float64]
Corners = NDArray[np.int32]


class Mesh(NamedTuple):
    """(n, 3) positions, (c,) the faces' corners one after the other, (f,) corners of each face."""

    positions: Positions
    corners: Corners
    sizes: Corners


Maker = Callable[[int, np.random.Generator], Mesh]
KINDS: dict[str, Maker] = {}


def kind(maker: Maker) -> Maker:
    """Adds a maker to the zoo."""
    KINDS[maker.__name__] = maker
    return maker


# ------------------------------------------------------------------------------------------------- building blocks


def polygons(positions: Positions, faces: NDArray[np.integer]) -> Mesh:
    """A mesh of (f, k) faces of k corners each."""
    sizes = np.full(len(faces), faces.shape[1], np.int32)
    return Mesh(np.ascontiguousarray(positions, float), faces.astype(np.int32).ravel(), sizes)


def joined(*meshes: Mesh) -> Mesh:
    """Several meshes as one, not connected."""
    starts = np.cumsum([0] + [len(mesh.positions) for mesh in meshes[:-1]])
    return Mesh(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([mesh.corners + start for mesh, start in zip(meshes, starts, strict=True)]).astype(np.int32),
        np.concatenate([mesh.sizes for mesh in meshes]),
    )


def moved(mesh: Mesh, positions: Positions) -> Mesh:
    return mesh._replace(positions=np.ascontiguousarray(positions, float))


def quads(rows: int, columns: int) -> Corners:
    """The faces of a grid of rows x columns vertices."""
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(columns - 1), indexing="ij")
    first = (i * columns + j).ravel()
    return np.column_stack([first, first + columns, first + columns + 1, first + 1]).astype(np.int32)


def sheet(rows: int, columns: int) -> Mesh:
    """A wavy grid with edges of about 1."""
    x, y = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    positions = np.stack([x, y, 0.3 * np.sin(x) * np.cos(y)], axis=-1).reshape(-1, 3)
    return polygons(positions, quads(rows, columns))


def square(n: int) -> Mesh:
    side = max(3, round(n**0.5))
    return sheet(side, side)


def ring(n: int) -> Positions:
    angle = np.arange(n) * (2 * np.pi / n)
    return np.column_stack([np.cos(angle), np.sin(angle), np.zeros(n)])


# ------------------------------------------------------------------------------------------------- the tame ones


@kind
def grid(n: int, _: np.random.Generator) -> Mesh:
    """What the others are compared with."""
    return square(n)


@kind
def strip(n: int, _: np.random.Generator) -> Mesh:
    return sheet(max(2, n // 2), 2)


@kind
def flat(n: int, _: np.random.Generator) -> Mesh:
    mesh = square(n)
    return moved(mesh, mesh.positions * [1, 1, 0])


# ------------------------------------------------------------------------------------------------- shapes without area


@kind
def one_point(n: int, _: np.random.Generator) -> Mesh:
    mesh = square(n)
    return moved(mesh, np.full_like(mesh.positions, 3.0))


@kind
def two_points(n: int, _: np.random.Generator) -> Mesh:
    mesh = square(n)
    return moved(mesh, np.repeat((np.arange(len(mesh.positions)) % 2.0)[:, None], 3, axis=1))


@kind
def collinear(n: int, _: np.random.Generator) -> Mesh:
    mesh = square(n)
    return moved(mesh, mesh.positions * [1, 0, 0])


@kind
def collinear_polygon(n: int, _: np.random.Generator) -> Mesh:
    return polygons(np.arange(n)[:, None] * [1.0, 0.0, 0.0], np.arange(n)[None])


@kind
def needles(n: int, _: np.random.Generator) -> Mesh:
    mesh = square(n)
    return moved(mesh, mesh.positions * [1e-9, 1, 1])


@kind
def caps(n: int, _: np.random.Generator) -> Mesh:
    """Sheared so far that each angle is near 0 or 180 degrees."""
    mesh = square(n)
    return moved(mesh, mesh.positions + mesh.positions[:, [1]] * [1e4, 0, 0])


@kind
def caps_on_one_edge(n: int, _: np.random.Generator) -> Mesh:
    """Vertices on the edge that all triangles share."""
    positions = np.zeros((n, 3))
    positions[1, 0] = 1
    positions[2:, 0] = np.linspace(0.2, 0.8, n - 2)
    return polygons(positions, np.column_stack([np.zeros(n - 2), np.ones(n - 2), np.arange(2, n)]))


@kind
def collapsed_rows(n: int, _: np.random.Generator) -> Mesh:
    """Every second row of a grid lies on the row before it."""
    mesh = square(n)
    return moved(mesh, mesh.positions - (mesh.positions[:, [0]] % 2) * [1, 0, 0])


# ------------------------------------------------------------------------------------------------- scales


@kind
def all_scales(n: int, rng: np.random.Generator) -> Mesh:
    mesh = square(n)
    return moved(mesh, mesh.positions * 10.0 ** rng.uniform(-12, 12, (len(mesh.positions), 1)))


@kind
def tiny(n: int, _: np.random.Generator) -> Mesh:
    mesh = square(n)
    return moved(mesh, mesh.positions * 1e-30)


@kind
def huge(n: int, _: np.random.Generator) -> Mesh:
    mesh = square(n)
    return moved(mesh, mesh.positions * 1e30)


@kind
def far_from_the_origin(n: int, _: np.random.Generator) -> Mesh:
    mesh = square(n)
    return moved(mesh, mesh.positions + 1e9)


def with_a_vertex_far_away(n: int, sizes_away: float) -> Mesh:
    mesh = square(n)
    positions = mesh.positions.copy()
    positions[0] = [sizes_away * np.ptp(positions), 0, 0]
    return moved(mesh, positions)


@kind
def exploded_vertex(n: int, _: np.random.Generator) -> Mesh:
    return with_a_vertex_far_away(n, 1e4)


@kind
def vertex_at_infinity(n: int, _: np.random.Generator) -> Mesh:
    return with_a_vertex_far_away(n, 1e12)


@kind
def cluster_beside_a_triangle(n: int, _: np.random.Generator) -> Mesh:
    """Almost all vertices within a billionth of the box."""
    mesh = square(n)
    return joined(moved(mesh, mesh.positions * 1e-9 / np.ptp(mesh.positions)), polygons(np.eye(3), np.arange(3)[None]))


@kind
def half_cluster(n: int, _: np.random.Generator) -> Mesh:
    """Edge lengths fall by a tenth each row, then stay at their least."""
    mesh = square(n)
    x = mesh.positions[:, [0]]
    return moved(mesh, np.hstack([np.exp(-0.1 * np.minimum(x, 200)), mesh.positions[:, 1:] * 0.01]))


# ------------------------------------------------------------------------------------------------- loose and apart


def with_loose_vertices(positions: Positions) -> Mesh:
    mesh = sheet(30, 30)
    return moved(mesh, np.concatenate([mesh.positions, positions]))


@kind
def loose_vertices(n: int, rng: np.random.Generator) -> Mesh:
    return with_loose_vertices(30 * rng.normal(size=(n, 3)))


@kind
def loose_vertices_in_one_place(n: int, _: np.random.Generator) -> Mesh:
    return with_loose_vertices(np.zeros((n, 3)))


@kind
def loose_vertices_of_all_scales(n: int, rng: np.random.Generator) -> Mesh:
    return with_loose_vertices(rng.normal(size=(n, 3)) * 10.0 ** rng.uniform(-12, 12, (n, 1)))


@kind
def nothing_but_loose(n: int, rng: np.random.Generator) -> Mesh:
    return Mesh(rng.normal(size=(n, 3)), np.zeros(0, np.int32), np.zeros(0, np.int32))


@kind
def triangles_apart(n: int, rng: np.random.Generator) -> Mesh:
    corners = rng.normal(size=(n // 3, 1, 3)) * 100 + rng.normal(size=(1, 3, 3))
    return polygons(corners.reshape(-1, 3), np.arange(n // 3 * 3).reshape(-1, 3))


@kind
def triangles_in_one_place(n: int, rng: np.random.Generator) -> Mesh:
    return polygons(np.tile(rng.normal(size=(3, 3)), (n // 3, 1)), np.arange(n // 3 * 3).reshape(-1, 3))


@kind
def triangles_across_each_other(n: int, rng: np.random.Generator) -> Mesh:
    """Each as large as the whole."""
    positions = rng.normal(size=(n // 3 * 3, 3))
    positions /= np.linalg.norm(positions, axis=1)[:, None]
    return polygons(positions, np.arange(len(positions)).reshape(-1, 3))


@kind
def cubes_in_one_place(n: int, _: np.random.Generator) -> Mesh:
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    faces = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    count = max(1, n // 8)
    positions = corners[None] + 1e-6 * np.arange(count)[:, None, None]
    return polygons(positions.reshape(-1, 3), (faces[None] + 8 * np.arange(count)[:, None, None]).reshape(-1, 4))


# ------------------------------------------------------------------------------------------------- sheets and walls


def stacked(n: int, count: int, distance: float) -> Mesh:
    """Sheets above each other, every second one inside out."""
    side = max(3, round((n / count) ** 0.5))
    layers = []
    for layer in range(count):
        mesh = sheet(side, side)
        faces = mesh.corners.reshape(-1, 4)[:, :: -1 if layer % 2 else 1]
        layers.append(polygons(mesh.positions + np.array([0, 0, distance * layer]), faces))
    return joined(*layers)


@kind
def two_walls(n: int, _: np.random.Generator) -> Mesh:
    return stacked(n, 2, 1e-3 * n**0.5)


@kind
def two_walls_in_one_place(n: int, _: np.random.Generator) -> Mesh:
    return stacked(n, 2, 0.0)


@kind
def many_walls(n: int, _: np.random.Generator) -> Mesh:
    return stacked(n, min(200, max(2, n // 16)), 1e-4)


@kind
def crumpled(n: int, rng: np.random.Generator) -> Mesh:
    """Cuts itself everywhere."""
    mesh = square(n)
    return moved(mesh, np.tanh(rng.normal(size=mesh.positions.shape)))


@kind
def open_seams(n: int, _: np.random.Generator) -> Mesh:
    """Each face has vertices of its own, at the places of its neighbours'."""
    mesh = square(n // 4)
    return polygons(mesh.positions[mesh.corners], np.arange(len(mesh.corners)).reshape(-1, 4))


@kind
def torn_seams(n: int, rng: np.random.Generator) -> Mesh:
    """As open_seams, but rounded apart."""
    mesh = open_seams(n, rng)
    return moved(mesh, mesh.positions * (1 + 6e-8 * rng.normal(size=mesh.positions.shape)))


# ------------------------------------------------------------------------------------------------- orientation


@kind
def inside_out(n: int, _: np.random.Generator) -> Mesh:
    mesh = square(n)
    return polygons(mesh.positions, mesh.corners.reshape(-1, 4)[:, ::-1])


@kind
def random_orientation(n: int, rng: np.random.Generator) -> Mesh:
    mesh = square(n)
    faces = mesh.corners.reshape(-1, 4)
    flipped = rng.random(len(faces)) < 0.5
    return polygons(mesh.positions, np.where(flipped[:, None], faces[:, ::-1], faces))


def strip_around(n: int, closed: bool) -> tuple[NDArray[np.float64], NDArray[np.float64], Corners]:
    """Parameters and faces of a band whose ends meet upside down; ``closed``: its sides meet, too."""
    side = max(4, round(n**0.5))
    u, v = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    i, j = np.meshgrid(np.arange(side), np.arange(side if closed else side - 1), indexing="ij")

    def index(i: NDArray[np.int64], j: NDArray[np.int64]) -> NDArray[np.int64]:
        upside_down = -j % side if closed else side - 1 - j
        return np.where(i == side, upside_down, i % side * side + j % side)

    faces = np.stack([index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)], axis=-1)
    return u.ravel() / side, v.ravel() / side, faces.reshape(-1, 4).astype(np.int32)


@kind
def moebius_strip(n: int, _: np.random.Generator) -> Mesh:
    u, v, faces = strip_around(n, closed=False)
    u, v = 2 * np.pi * u, v - 0.5
    radius = 1 + v * np.cos(u / 2)
    return polygons(np.column_stack([radius * np.cos(u), radius * np.sin(u), v * np.sin(u / 2)]), faces)


@kind
def klein_bottle(n: int, _: np.random.Generator) -> Mesh:
    u, v, faces = strip_around(n, closed=True)
    u, v = 2 * np.pi * u, 2 * np.pi * v
    radius = 2 + np.cos(u / 2) * np.sin(v) - np.sin(u / 2) * np.sin(2 * v)
    height = np.sin(u / 2) * np.sin(v) + np.cos(u / 2) * np.sin(2 * v)
    return polygons(np.column_stack([radius * np.cos(u), radius * np.sin(u), height]), faces)


# ------------------------------------------------------------------------------------------------- non-manifold


@kind
def faces_twenty_times(n: int, _: np.random.Generator) -> Mesh:
    mesh = square(n // 4)
    return mesh._replace(corners=np.tile(mesh.corners, 20), sizes=np.tile(mesh.sizes, 20))


@kind
def one_face_often(n: int, rng: np.random.Generator) -> Mesh:
    return polygons(rng.normal(size=(3, 3)), np.tile(np.arange(3), (n, 1)))


@kind
def faces_with_repeated_corners(n: int, rng: np.random.Generator) -> Mesh:
    mesh = square(n)
    faces = mesh.corners.reshape(-1, 4).copy()
    repeated = rng.random(len(faces)) < 0.3
    faces[repeated, 2] = faces[repeated, 0]
    return polygons(mesh.positions, faces)


@kind
def touching_at_a_vertex(n: int, _: np.random.Generator) -> Mesh:
    """Two sheets with one vertex in common."""
    mesh = square(n // 2)
    count = len(mesh.positions)
    other = np.where(mesh.corners == 0, count - 1, mesh.corners + count - 1)
    positions = np.concatenate([mesh.positions, (mesh.positions + mesh.positions[-1])[1:]])
    return Mesh(positions, np.concatenate([mesh.corners, other]).astype(np.int32), np.tile(mesh.sizes, 2))


@kind
def fan_on_an_edge(n: int, rng: np.random.Generator) -> Mesh:
    """All triangles share one edge."""
    corners = np.column_stack([np.zeros(n - 2), np.ones(n - 2), np.arange(2, n)])
    return polygons(rng.normal(size=(n, 3)), corners)


@kind
def fan_at_a_vertex(n: int, rng: np.random.Generator) -> Mesh:
    """All triangles share one vertex and no edge."""
    i = np.arange((n - 1) // 2)
    return polygons(rng.normal(size=(2 * len(i) + 1, 3)), np.column_stack([0 * i, 2 * i + 1, 2 * i + 2]))


@kind
def umbrella(n: int, _: np.random.Generator) -> Mesh:
    """A closed fan around one vertex."""
    i = np.arange(n - 1)
    positions = np.concatenate([[[0, 0, 0.1]], ring(n - 1)])
    return polygons(positions, np.column_stack([0 * i, 1 + i, 1 + (i + 1) % (n - 1)]))


def with_hubs(n: int, count: int, rng: np.random.Generator) -> Mesh:
    """A grid and vertices that have an edge to each of its vertices."""
    mesh = square(n)
    first = len(mesh.positions)
    i = np.arange(first - 1)
    positions = np.concatenate([mesh.positions, rng.normal(size=(count, 3)) * n**0.5])
    spokes = [polygons(positions, np.column_stack([i, i + 1, 0 * i + first + hub])) for hub in range(count)]
    corners = np.concatenate([mesh.corners, *(part.corners for part in spokes)])
    return Mesh(positions, corners, np.concatenate([mesh.sizes, *(part.sizes for part in spokes)]))


@kind
def hub(n: int, rng: np.random.Generator) -> Mesh:
    return with_hubs(n, 1, rng)


@kind
def thirty_hubs(n: int, rng: np.random.Generator) -> Mesh:
    return with_hubs(n, 30, rng)


@kind
def soup(n: int, rng: np.random.Generator) -> Mesh:
    """Random triangles over all vertices: no order of elimination keeps their factor small."""
    return polygons(rng.normal(size=(n, 3)), rng.integers(0, n, (2 * n, 3)))


@kind
def soup_of_neighbours(n: int, rng: np.random.Generator) -> Mesh:
    near = min(50, n)
    start = rng.integers(0, n - near + 1, (2 * n, 1))
    return polygons(rng.normal(size=(n, 3)), start + rng.integers(0, near, (2 * n, 3)))


# ------------------------------------------------------------------------------------------------- n-gons


@kind
def one_polygon(n: int, _: np.random.Generator) -> Mesh:
    return polygons(ring(n), np.arange(n)[None])


@kind
def cylinder_with_polygon_ends(n: int, _: np.random.Generator) -> Mesh:
    around = n // 2
    i = np.arange(around)
    sides = np.column_stack([i, (i + 1) % around, (i + 1) % around + around, i + around])
    positions = np.concatenate([ring(around), ring(around) + np.array([0, 0, 2])])
    corners = np.concatenate([sides.ravel(), i[::-1], i + around])
    return Mesh(positions, corners.astype(np.int32), np.array([4] * around + [around] * 2, np.int32))


@kind
def thousand_corners(n: int, _: np.random.Generator) -> Mesh:
    """Polygons of a thousand corners, apart."""
    corners = min(1000, n)
    count = max(1, n // corners)
    positions = ring(corners)[None] + 0.01 * np.arange(count)[:, None, None] * [0, 0, 1]
    return polygons(positions.reshape(-1, 3), np.arange(count * corners).reshape(count, corners))


@kind
def shuffled_polygons(n: int, rng: np.random.Generator) -> Mesh:
    """Polygons of a thousand corners over the same vertices in any order."""
    corners = min(1000, n)
    return polygons(ring(corners), rng.permuted(np.tile(np.arange(corners), (max(1, n // corners), 1)), axis=1))
