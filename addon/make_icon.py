# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws the icon of the tool ARAP Pull: a surface that an arrow pulls up to a hill.

Usage: make_icon.py OUT.dat

Blender's icons of tools are triangles in bytes: "VCO", 0, width, height, start (2 bytes); then x, y of all corners;
then red, green, blue, alpha of all corners.
"""

from __future__ import annotations

import itertools
import math
import sys
from pathlib import Path

Point = tuple[float, float]
Color = tuple[int, int, int, int]

WHITE: Color = (230, 230, 230, 255)
ORANGE: Color = (250, 160, 60, 255)
N_STEPS = 24


def hill(x: float) -> float:
    """Height of the surface at x, both from 0 to 255."""
    return 60.0 + 85.0 * math.exp(-(((x - 118.0) / 42.0) ** 2))


def surface() -> list[tuple[Point, Color]]:
    """A band along the hill."""
    corners: list[tuple[Point, Color]] = []
    xs = [20.0 + i * 196.0 / N_STEPS for i in range(N_STEPS + 1)]
    for left, right in itertools.pairwise(xs):
        quad = ((left, hill(left)), (right, hill(right)), (right, hill(right) - 22.0), (left, hill(left) - 22.0))
        corners += [(quad[i], WHITE) for i in (0, 1, 2, 0, 2, 3)]
    return corners


def arrow() -> list[tuple[Point, Color]]:
    """Up and to the right, from the top of the hill."""
    shaft = ((126.0, 152.0), (138.0, 146.0), (174.0, 206.0), (162.0, 212.0))
    head = ((146.0, 212.0), (188.0, 188.0), (190.0, 240.0))
    return [(shaft[i], ORANGE) for i in (0, 1, 2, 0, 2, 3)] + [(point, ORANGE) for point in head]


def icon() -> bytes:
    """The file's bytes."""
    corners = surface() + arrow()
    places = bytes(round(value) for point, _ in corners for value in point)
    colors = bytes(value for _, color in corners for value in color)
    return b"VCO\0" + bytes((255, 255, 0, 0)) + places + colors


if __name__ == "__main__":
    Path(sys.argv[1]).write_bytes(icon())
