# SPDX-License-Identifier: GPL-3.0-or-later
"""The types of the arrays that everything here passes on, and a check of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Float32s = NDArray[np.float32]
Ints = NDArray[np.int32]


def check_places(points: Float32s, name: str) -> None:
    """Raises ValueError if a vertex of the object of that name is at no finite place. ``points``: (n, 3)."""
    is_finite = np.isfinite(points).all(axis=1)
    if not is_finite.all():
        raise ValueError(f"Vertex {int(is_finite.argmin())} of '{name}' is at no finite place: repair or remove it")
