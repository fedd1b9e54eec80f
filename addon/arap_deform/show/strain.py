# SPDX-License-Identifier: GPL-3.0-or-later
"""How much longer or shorter than at rest the edges around each vertex are, and a colour for it. No bpy."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Float32s, Floats

SHORTER = (0.10, 0.30, 0.95)
SAME = (0.82, 0.82, 0.80)
LONGER = (0.90, 0.10, 0.08)
OPACITY = 0.7  # the shading of the mesh stays visible below


class EdgeStrain:
    """The edges of a mesh at rest."""

    def __init__(self, rest: Float32s, edges: NDArray[np.int32], stretch: Floats) -> None:
        """Measures the edges.

        Args:
            rest: (n, 3) positions at rest, object space.
            edges: (e, 2) vertices.
            stretch: (3, 3) what the object's scale does: lengths are measured as seen.
        """
        self._stretch = stretch.astype(np.float32)
        self._n = len(rest)
        lengths = self._lengths(rest, edges)
        # Edges without a length have no strain, whatever they become.
        has_length = lengths > 1e-7 * lengths.max(initial=0.0)
        self._edges = np.ascontiguousarray(edges[has_length].T, dtype=np.intp)
        self._per_length = 1.0 / lengths[has_length]
        n_edges = np.bincount(self._edges.ravel(), minlength=self._n)
        self._per_vertex = 1.0 / np.maximum(n_edges, 1)

    def of(self, positions: Float32s) -> Float32s:
        """(n,) mean of (length now / length at rest - 1) over the edges of each vertex; 0 where it has none."""
        strain = self._lengths(positions, self._edges.T) * self._per_length - 1.0
        first, second = self._edges
        total = np.bincount(first, strain, self._n) + np.bincount(second, strain, self._n)
        return np.asarray(total * self._per_vertex, dtype=np.float32)

    def _lengths(self, positions: Float32s, edges: NDArray[np.integer]) -> Float32s:
        seen = positions @ self._stretch
        along = seen.take(edges[:, 0], axis=0) - seen.take(edges[:, 1], axis=0)
        return np.asarray(np.sqrt(np.einsum("ij,ij->i", along, along)))


def colors_of(strain: Float32s, limit: float) -> Float32s:
    """(n, 4) float32 RGBA: blue for shorter, grey for the same, red for longer; full at ``limit`` and beyond."""
    part = np.clip(strain / limit, -1.0, 1.0)
    colors = np.empty((len(strain), 4), dtype=np.float32)
    for channel, (low, middle, high) in enumerate(zip(SHORTER, SAME, LONGER, strict=True)):
        colors[:, channel] = np.interp(part, (-1.0, 0.0, 1.0), (low, middle, high))
    colors[:, 3] = OPACITY
    return colors
