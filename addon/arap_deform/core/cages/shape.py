# SPDX-License-Identifier: GPL-3.0-or-later
"""What the artist edits of a cage, as arrays and as text."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Float32s

SINGLE, DOUBLE = "<f4", "<f8"


@dataclass(frozen=True)
class CageShape:
    """The mesh of a cage before its modifiers.

    Attributes:
        positions: (c, 3) of the mesh itself; of the reference key, if there are shape keys.
        keys: (c, 3) of each other shape key, by name, and its value.
    """

    positions: Float32s
    keys: Mapping[str, tuple[Float32s, float]]

    def to_text(self) -> str:
        """For from_text()."""
        keys = {name: (encoded(positions, SINGLE), value) for name, (positions, value) in self.keys.items()}
        return json.dumps({"positions": encoded(self.positions, SINGLE), "keys": keys})

    @classmethod
    def from_text(cls, text: str) -> CageShape | None:
        """None if the text is damaged."""
        try:
            saved = json.loads(text)
            keys = {name: (decoded(shape, SINGLE), float(value)) for name, (shape, value) in saved["keys"].items()}
            shape = cls(decoded(saved["positions"], SINGLE), keys)
        except (ValueError, TypeError, KeyError, AttributeError):
            return None
        is_sound = all(len(positions) == len(shape.positions) for positions, _ in shape.keys.values())
        return shape if is_sound and all(np.isfinite(value) for _, value in shape.keys.values()) else None


def encoded(positions: NDArray[np.floating], dtype: str) -> str:
    """(c, 3) positions as base64; ``dtype`` has a byte order, so that any machine reads it."""
    return base64.b64encode(positions.astype(dtype).tobytes()).decode()


def decoded(text: str, dtype: str) -> NDArray[Any]:
    """What encoded() returned, in the byte order of this machine. Raises ValueError: damaged, or not finite."""
    saved = np.frombuffer(base64.b64decode(text), dtype).reshape(-1, 3)
    if not np.isfinite(saved).all():
        raise ValueError("not finite")
    return saved.astype(saved.dtype.newbyteorder("="))
