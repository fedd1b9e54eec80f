# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes that wait until all of them are solved: in memory while they are few, else in a temporary file. No bpy."""

from __future__ import annotations

import tempfile

import numpy as np

from ..core.arrays import Float32s

BYTES_IN_MEMORY = 64_000_000


class ShapeStore:
    """A list of (n, 3) float32 arrays that takes at most BYTES_IN_MEMORY; the file goes with it."""

    def __init__(self, n_vertices: int) -> None:
        self._n_bytes = n_vertices * 12
        self._file = tempfile.SpooledTemporaryFile(max_size=BYTES_IN_MEMORY, prefix="arap-")  # noqa: SIM115
        self._n = 0

    def __len__(self) -> int:
        return self._n

    def append(self, shape: Float32s) -> None:
        """Raises RuntimeError where the disk is full."""
        try:
            self._file.seek(self._n * self._n_bytes)
            self._file.write(np.ascontiguousarray(shape, dtype=np.float32).tobytes())
        except OSError as error:
            raise RuntimeError(
                f"The solved shapes do not fit into the folder for temporary files ({error.strerror}): "
                "make room there, or bake fewer frames at once"
            ) from error
        self._n += 1

    def __getitem__(self, index: int) -> Float32s:
        if not 0 <= index < self._n:
            raise IndexError(index)
        self._file.seek(index * self._n_bytes)
        return np.frombuffer(self._file.read(self._n_bytes), dtype=np.float32).reshape(-1, 3)

    def close(self) -> None:
        """Gives memory and disk back; the shapes are gone."""
        self._file.close()
        self._n = 0
