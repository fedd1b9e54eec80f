# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""The shape in which a pin or handle holds its vertices, as saved."""

import base64
import secrets

import numpy as np
from bpy.props import IntProperty, StringProperty
from numpy.typing import NDArray


class HeldShape:
    """A mixin for what was added to a posed mesh: it holds its vertices as they were shown, not as at rest."""

    shape_text: StringProperty(
        options={"HIDDEN"},
        description="Number of the mesh vertices, then vertices (int32) and their offsets from rest (float32), base64",
    )
    shape_id: IntProperty(options={"HIDDEN"}, description="Number of that shape; 0: the shape at rest")

    @property
    def shape(self) -> tuple[NDArray[np.int32], NDArray[np.float32], int]:
        """(k,) vertices, (k, 3) their offsets from rest, and the number of vertices of the mesh.

        There are none if the shape is that at rest, or what is saved is damaged.
        """
        nothing = np.zeros(0, np.int32), np.zeros((0, 3), np.float32), 0
        try:
            saved = base64.b64decode(self.shape_text)
            n, vertices = np.frombuffer(saved, "<i4", 1)[0], np.frombuffer(saved, "<i4", len(saved) // 16, 4)
            offsets = np.frombuffer(saved, "<f4", offset=4 + vertices.nbytes).reshape(-1, 3)
        except ValueError:
            return nothing
        is_sound = len(offsets) == len(vertices) and np.isfinite(offsets).all()
        is_sound = is_sound and bool(np.all((vertices >= 0) & (vertices < n)))
        return (vertices.astype(np.int32), offsets.astype(np.float32), int(n)) if is_sound else nothing

    def set_shape(self, vertices: NDArray[np.int32], offsets: NDArray[np.floating], n: int) -> None:
        """See shape."""
        parts = np.array([n], "<i4"), vertices.astype("<i4"), offsets.astype("<f4")
        self.shape_text = base64.b64encode(b"".join(part.tobytes() for part in parts)).decode()
        self.shape_id = 1 + secrets.randbelow(2**31 - 2)

    def forget_shape(self) -> None:
        """Holds the shape at rest from now on."""
        self.shape_text, self.shape_id = "", 0
