# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the cage of a model by rings and lofts; for a mirror-symmetric one only the half with x >= 0."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import cos, pi, sin

import numpy as np
from numpy.typing import NDArray

from .quad_mesh import FLIP_X, Floats, QuadMesh

Point = Sequence[float] | NDArray[np.float64]


class Cage:
    """Vertices and quads. In a symmetric model vertices made by ``seam`` lie on the mirror plane, all others at x > 0.

    Loops are lists of vertices, counter-clockwise seen from where a loft goes to. A half loop starts and ends on the
    seam.

    Attributes:
        tag: written into each quad made.
        weights: written into each vertex made.
    """

    def __init__(self) -> None:
        self._positions: list[Floats] = []
        self._is_seam: list[bool] = []
        self._weights: list[dict[str, float]] = []
        self._quads: list[tuple[int, int, int, int]] = []
        self._tags: list[int] = []
        self._paths: dict[str, list[int]] = {}
        self.tag = 0
        self.weights: dict[str, float] = {}

    def vertex(self, point: Point) -> int:
        self._positions.append(np.array(point, dtype=np.float64))
        self._is_seam.append(False)
        self._weights.append(dict(self.weights))
        return len(self._positions) - 1

    def seam(self, point: Point) -> int:
        index = self.vertex((0.0, point[1], point[2]))
        self._is_seam[index] = True
        return index

    def loop(self, points: Sequence[Point]) -> list[int]:
        return [self.vertex(point) for point in points]

    def half_loop(self, points: Sequence[Point]) -> list[int]:
        return [self.seam(points[0]), *self.loop(points[1:-1]), self.seam(points[-1])]

    def quad(self, a: int, b: int, c: int, d: int) -> None:
        self._quads.append((a, b, c, d))
        self._tags.append(self.tag)

    def loft(self, lower: Sequence[int], upper: Sequence[int]) -> None:
        """Quads between two loops."""
        self.loft_half([*lower, lower[0]], [*upper, upper[0]])

    def loft_half(self, lower: Sequence[int], upper: Sequence[int]) -> None:
        """Quads between two half loops."""
        for i in range(len(lower) - 1):
            self.quad(lower[i], lower[i + 1], upper[i + 1], upper[i])

    def cap(self, loop: Sequence[int], centre: Point) -> None:
        """Closes a loop of an even number of vertices by quads around a new vertex."""
        middle = self.vertex(centre)
        for i in range(0, len(loop), 2):
            self.quad(loop[i - 1], loop[i], loop[i + 1], middle)

    def cap_half(self, loop: Sequence[int], centre: Point) -> None:
        """Closes a half loop of an odd number of vertices by quads around a new vertex on the seam."""
        middle = self.seam(centre)
        for i in range(0, len(loop) - 1, 2):
            self.quad(middle, loop[i], loop[i + 1], loop[i + 2])

    def position(self, index: int) -> Floats:
        return self._positions[index].copy()

    def move(self, index: int, point: Point) -> None:
        self._positions[index] = np.array(point, dtype=np.float64)
        if self._is_seam[index]:
            self._positions[index][0] = 0.0

    def open_block(self, loops: Sequence[Sequence[int]], k: int, j: int, size: int = 2) -> list[int]:
        """Removes size x size quads, from loop k and place j on; returns the 4 size vertices around the hole."""
        block = {loop[(j + b) % len(loop)] for loop in loops[k : k + size + 1] for b in range(size + 1)}
        kept = [i for i, quad in enumerate(self._quads) if not set(quad) <= block]
        self._quads = [self._quads[i] for i in kept]
        self._tags = [self._tags[i] for i in kept]
        steps = range(size)
        around = [(a, 0) for a in steps] + [(size, b) for b in steps]
        around += [(size - a, size) for a in steps] + [(0, size - b) for b in steps]
        return [loops[k + a][(j + b) % len(loops[k + a])] for a, b in around]

    def path(self, name: str, vertices: Sequence[int]) -> None:
        """Names a chain of edges; in a mirrored cage its image has the same name with "_mirror" after it."""
        self._paths[name] = list(vertices)

    def whole(self) -> QuadMesh:
        """The cage as it is, without vertices in no quad; face data "tag", vertex data by the names in ``weights``."""
        quads = np.array(self._quads, dtype=np.int32)
        used = np.unique(quads)
        renumber = np.full(len(self._positions), -1, dtype=np.int32)
        renumber[used] = np.arange(len(used), dtype=np.int32)
        rows = [self._weights[k] for k in used]
        names = sorted({name for row in rows for name in row})
        return QuadMesh(
            positions=np.array(self._positions)[used],
            quads=renumber[quads],
            vertex_data={name: np.array([[row.get(name, 0.0)] for row in rows]) for name in names},
            face_data={"tag": np.array(self._tags, dtype=np.int32)},
            paths={name: renumber[np.array(path)] for name, path in self._paths.items()},
        )

    def mirrored(self) -> QuadMesh:
        """The closed mesh of this half and its mirror image."""
        half = self.whole()
        used = np.unique(np.array(self._quads, dtype=np.int32))
        inside = np.flatnonzero(~np.array(self._is_seam)[used]).astype(np.int32)
        n = len(half.positions)
        partner = np.arange(n, dtype=np.int32)
        partner[inside] = n + np.arange(len(inside), dtype=np.int32)
        images = {name + "_mirror": partner[path] for name, path in half.paths.items()}
        return QuadMesh(
            positions=np.concatenate([half.positions, half.positions[inside] * FLIP_X]),
            quads=np.concatenate([half.quads, partner[half.quads][:, ::-1]]),
            mirror=np.concatenate([partner, inside]),
            vertex_data={name: np.concatenate([v, v[inside]]) for name, v in half.vertex_data.items()},
            face_data={name: np.concatenate([v, v]) for name, v in half.face_data.items()},
            paths=half.paths | images,
        )


def ellipse(centre: Point, axis_u: Point, axis_v: Point, n: int = 8, phase: float = 0.0) -> list[Floats]:
    """Points centre + cos a u + sin a v, a from ``phase`` on; counter-clockwise seen from u x v."""
    centre, u, v = (np.asarray(p, dtype=np.float64) for p in (centre, axis_u, axis_v))
    angles = [phase + 2 * pi * i / n for i in range(n)]
    return [centre + cos(a) * u + sin(a) * v for a in angles]


def rings_along(cage: Cage, loop: Sequence[int], centres: Floats, radii: Floats, side: Point) -> Iterator[list[Floats]]:
    """Rings of points around a line, which are lofted one after the other from a square hole in a cage.

    Args:
        cage: the cage.
        loop: the vertices around the hole, the first one at a corner of it.
        centres: (m, 3) places along the line.
        radii: (m, 2) of the rings' ellipses, across ``side`` and along it.
        side: a direction across the line.
    """
    n, tangents = len(loop), np.gradient(centres, axis=0)
    hole = np.array([cage.position(i) for i in loop])
    offset = hole[0] - hole.mean(axis=0)
    for centre, radius, tangent in zip(centres, radii, tangents, strict=True):
        across = np.cross(side, tangent)
        across /= np.linalg.norm(across)
        along = np.cross(tangent, across) / np.linalg.norm(tangent)
        # The hole is a square, whose first vertex is a corner: the ring keeps its turn in steps of whole vertices.
        phase = round(float(np.arctan2(offset @ along, offset @ across)) / (2 * pi / n)) * (2 * pi / n)
        points = ellipse(centre, radius[0] * across, radius[1] * along, n, phase)
        yield points
        offset = points[0] - centre
