# SPDX-License-Identifier: GPL-3.0-or-later
"""What is known of surfaces of triangles: positions (n, 3), triangles (f, 3)."""

import numpy as np


def faces_at_sides(triangles):
    """How many sides of faces have one face, two, three ..., from 0 on."""
    sides = np.sort(directed_sides(triangles), axis=1)
    return np.bincount(np.unique(sides, axis=0, return_counts=True)[1])


def is_closed(triangles):
    """Whether every side of a face is the reversed side of exactly one other."""
    sides, counts = np.unique(directed_sides(triangles), axis=0, return_counts=True)
    return np.all(counts == 1) and np.array_equal(np.unique(sides[:, ::-1], axis=0), sides)


def directed_sides(triangles):
    return np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=-1).reshape(-1, 2)


def areas(positions, triangles):
    a, b, c = np.moveaxis(positions[triangles], 1, 0)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def volume(positions, triangles):
    a, b, c = np.moveaxis(positions[triangles], 1, 0)
    return np.einsum("fi,fi->", a, np.cross(b, c)) / 6
