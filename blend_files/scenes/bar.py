# SPDX-License-Identifier: GPL-3.0-or-later
"""The bar that papers twist and bend, as arrays; needs numpy alone."""

from __future__ import annotations

import numpy as np

from .quad_mesh import Floats, Ints, QuadMesh

SIZE = (0.5, 0.5, 2.0)
CELLS = (12, 12, 48)
CHECK = 3  # cells a side of the pattern's squares


def bar() -> QuadMesh:
    """A closed box of squares, standing on z = 0; face data "tag" is 0 or 1, a checker pattern."""
    nodes: dict[tuple[int, ...], int] = {}
    quads, tags = [], []
    for axis in range(3):
        u, v = (axis + 1) % 3, (axis + 2) % 3
        for end in (0, CELLS[axis]):
            for a in range(CELLS[u]):
                for b in range(CELLS[v]):
                    corners = [(a, b), (a + 1, b), (a + 1, b + 1), (a, b + 1)]
                    if end == 0:
                        corners.reverse()
                    quads.append([_node(nodes, {axis: end, u: i, v: j}) for i, j in corners])
                    tags.append((a // CHECK + b // CHECK + axis + (end > 0)) % 2)
    grid = np.array(list(nodes), dtype=np.float64)
    scale = np.array(SIZE) / np.array(CELLS)
    positions = grid * scale - np.array([SIZE[0] / 2, SIZE[1] / 2, 0.0])
    return QuadMesh(positions, np.array(quads, dtype=np.int32), face_data={"tag": np.array(tags, dtype=np.int32)})


def bar_groups(mesh: QuadMesh) -> dict[str, Ints]:
    """The vertices of both ends, one row of cells beyond the cap."""
    z: Floats = mesh.positions[:, 2]
    row = 1.5 * SIZE[2] / CELLS[2]
    masks = {"Bottom": z < row, "Top": z > SIZE[2] - row}
    return {name: np.flatnonzero(mask).astype(np.int32) for name, mask in masks.items()}


def _node(nodes: dict[tuple[int, ...], int], at: dict[int, int]) -> int:
    return nodes.setdefault((at[0], at[1], at[2]), len(nodes))
