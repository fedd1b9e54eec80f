# SPDX-License-Identifier: GPL-3.0-or-later
"""A shape with fewer vertices. No bpy."""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from ..arrays import Floats
from .shape import Shape, cells_of, clustered

SAME_PLACE = 1e-6  # of the size: vertices in a cube of this size are one, as on both sides of a seam
SAMPLED = 5  # vertices looked at in the search, for each one that may stay
MOST_TRIES = 30
GOOD_SHARE = 0.9  # of the number that may stay: the search ends there


def simplified(shape: Shape, most: int) -> Generator[None, None, Shape]:
    """The shape with at most so many vertices: those in a cube are one. Yields now and then.

    Vertices at the same place are one in any case.
    """
    size = SAME_PLACE * shape.size
    if len(shape.points) > most:
        sample = shape.points[:: max(1, len(shape.points) // (SAMPLED * most))]
        size = yield from _cube_size(sample, most, shape.size / np.sqrt(most))
        # The sample has not all places. Mostly one look at all vertices is enough.
        size = yield from _cube_size(shape.points, most, size, 0.0)
    yield
    return clustered(shape, size) if size > 0.0 else shape


def _cube_size(points: Floats, most: int, size: float, good_share: float = GOOD_SHARE) -> Generator[None, None, float]:
    """A size of cubes that at most so many, and no less than a share of these, have points in them."""
    too_small, large_enough = 0.0, np.inf
    for _ in range(MOST_TRIES):
        yield
        n = len(np.unique(cells_of(points, size)))
        if n > most:
            too_small = size
        else:
            large_enough = size
            if n >= good_share * most:
                break
        # The number of cubes that a surface meets goes with the square of their size.
        size *= np.sqrt(n / (most * (1.0 + good_share) / 2.0)) if good_share else 1.01 * np.sqrt(n / most)
        if not too_small < size < large_enough:
            size = 2.0 * too_small if large_enough == np.inf else (too_small + large_enough) / 2.0
    return large_enough if large_enough < np.inf else size
