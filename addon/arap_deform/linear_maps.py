# SPDX-License-Identifier: GPL-3.0-or-later
"""A linear map of many points, as each frame needs it. No bpy."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

# Rows of a product. For larger ones numpy's BLAS takes all its threads, which then wait for the next one by spinning:
# for tens of milliseconds they hold the cores that the solver needs at once (up to a third of a frame on two cores).
BLOCK = 8192


def map_points(points: NDArray[Any], linear: NDArray[Any], out: NDArray[Any]) -> None:
    """Writes points @ linear.T, on one thread.

    Args:
        points: (n, 3) contiguous.
        linear: (3, 3) of the same dtype.
        out: as points, and not them.

    Raises:
        ValueError: ``out`` is not contiguous.
    """
    if not out.flags.c_contiguous:
        raise ValueError("The mapped points need an array of their own: make it contiguous")
    whole = len(points) // BLOCK * BLOCK
    blocks = (-1, BLOCK, 3)
    np.matmul(points[:whole].reshape(blocks), linear.T, out=out[:whole].reshape(blocks))
    np.matmul(points[whole:], linear.T, out=out[whole:])
