# SPDX-License-Identifier: GPL-3.0-or-later
"""What the artist edits of a cage, as arrays and as text."""

from __future__ import annotations

import base64
import json
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ..arrays import Float32s


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
        keys = {name: (_encoded(positions), value) for name, (positions, value) in self.keys.items()}
        return json.dumps({"positions": _encoded(self.positions), "keys": keys})

    @classmethod
    def from_text(cls, text: str) -> CageShape | None:
        """None if the text is damaged."""
        try:
            saved = json.loads(text)
            keys = {name: (_decoded(shape), float(value)) for name, (shape, value) in saved["keys"].items()}
            shape = cls(_decoded(saved["positions"]), keys)
        except (ValueError, TypeError, KeyError, AttributeError):
            return None
        is_sound = all(len(positions) == len(shape.positions) for positions, _ in shape.keys.values())
        return shape if is_sound and all(np.isfinite(value) for _, value in shape.keys.values()) else None


def _encoded(positions: Float32s) -> str:
    return base64.b64encode(positions.astype("<f4").tobytes()).decode()


def _decoded(text: str) -> Float32s:
    positions = np.frombuffer(base64.b64decode(text), "<f4").reshape(-1, 3).astype(np.float32)
    if not np.isfinite(positions).all():
        raise ValueError("not finite")
    return positions
