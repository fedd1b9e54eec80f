# SPDX-License-Identifier: GPL-3.0-or-later
"""What an attached object is bound from, in arrays. No bpy."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..arrays import Float32s, Floats, Ints
from ..mirror import Mirror
from ..session_data import SessionMesh


@dataclass(frozen=True, kw_only=True)
class WrapInput:
    """What a wrap is made from. No Blender data.

    Attributes:
        name: of the attached object, for messages.
        mesh: the host, at rest, in its own space.
        stretch: (3, 3) of the host, see transforms.stretch_of().
        mirrors: planes that complete the host.
        points: (n, 3) float32 the attached object at rest, in its own space.
        place: (4, 4) from there to the space of the host.
        pieces: (n,) pieces that stay rigid; None: all bends.
        keeps_distance: near points keep their distance from the faces. Off: they follow them smoothly.
        threads: of the library; 0: as many as pay.
    """

    name: str
    mesh: SessionMesh
    stretch: Floats
    mirrors: Sequence[Mirror] = ()
    points: Float32s
    place: Floats
    pieces: Ints | None = None
    keeps_distance: bool = True
    threads: int = 0

    @property
    def if_cancelled(self) -> str:
        return f"Preparing '{self.name}' was cancelled; nothing has changed"

    @property
    def signature(self) -> int:
        """A fingerprint of the arrays: another one needs another bind, see also Wrap.is_of()."""
        pieces = np.zeros(0, dtype=np.int32) if self.pieces is None else self.pieces
        value = self.mesh.signature
        for array in (self.place, self.points, pieces):
            value = zlib.crc32(np.ascontiguousarray(array).tobytes(), value)
        return value
