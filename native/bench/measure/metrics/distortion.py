# SPDX-License-Identifier: GPL-3.0-or-later
"""How much lengths and areas of a surface changed."""

from __future__ import annotations

import numpy as np

from ..inputs.mesh import Floats, Ints, Mask

LEAST_AREA = 1e-12  # a share of that at rest: a face that has become a line does not count without end


def edge_strain(edges: Ints, rest: Floats, now: Floats, free: Mask) -> float:
    """Root of the mean square of the edges' relative changes of length, of edges (e, 2) with a free end."""
    edges = edges[free[edges].any(axis=1)]
    before, after = (np.linalg.norm(p[edges[:, 0]] - p[edges[:, 1]], axis=1) for p in (rest, now))
    return float(np.sqrt(np.mean((after / before - 1.0) ** 2)))


def area_distortion(triangles: Ints, rest: Floats, now: Floats, free: Mask) -> float:
    """Root of the mean square of log(area / area at rest), by area at rest, of faces with a free corner."""
    triangles = triangles[free[triangles].any(axis=1)]
    before, after = (_areas(p, triangles) for p in (rest, now))
    has_area = before > 0.0
    before, after = before[has_area], after[has_area]
    logs = np.log(np.maximum(after / before, LEAST_AREA))
    return float(np.sqrt(np.average(logs**2, weights=before)))


def _areas(positions: Floats, triangles: Ints) -> Floats:
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1))
