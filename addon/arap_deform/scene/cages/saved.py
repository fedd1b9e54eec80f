# SPDX-License-Identifier: GPL-3.0-or-later
"""What a handle that is a cage saves, as arrays; see props/cage."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from ...core.arrays import Floats
from ...core.cages.shape import DOUBLE, CageShape, decoded, encoded
from ...core.transforms import transformed

if TYPE_CHECKING:
    from ...props.handles import ArapHandle


def rest_of(handle: ArapHandle) -> Floats:
    """(c, 3) float64 positions of the cage's vertices at rest, not to be written to; none if they are damaged."""
    return _rest_in(handle.cage_text)


@lru_cache(maxsize=8)
def _rest_in(text: str) -> Floats:
    """Kept, as each update asks several times."""
    try:
        positions: Floats = decoded(text, DOUBLE)
    except ValueError:
        positions = np.zeros((0, 3))
    positions.flags.writeable = False
    return positions


def shape_of(handle: ArapHandle) -> CageShape | None:
    """What the artist edits of the cage, at rest, with the shape keys that shape it there; None if damaged."""
    return CageShape.from_text(handle.cage_shape_text)


def save(handle: ArapHandle, positions: Floats, shape: CageShape) -> None:
    """See rest_of() and shape_of()."""
    handle.cage_text, handle.cage_shape_text = encoded(positions, DOUBLE), shape.to_text()


def move_rest(handle: ArapHandle, matrix: Floats) -> None:
    """Moves rest_of(), if there is one, by a (4, 4) matrix."""
    if handle.cage_text:
        handle.cage_text = encoded(transformed(matrix, rest_of(handle)), DOUBLE)


def forget(handle: ArapHandle) -> None:
    """Nothing is known of its rest."""
    handle.cage_text = handle.cage_shape_text = ""
