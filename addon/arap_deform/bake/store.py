# SPDX-License-Identifier: GPL-3.0-or-later
"""Solved shapes until the job ends: in memory if they are few, else in a temporary file. No bpy."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from ..core.arrays import Float32s
from .estimate import BYTES_PER_VERTEX
from .whole_file import check_space

BYTES_IN_MEMORY = 64_000_000
FEWER = "bake fewer frames at once"


class ShapeStore:
    """A list of (n, 3) float32 arrays; above BYTES_IN_MEMORY they are on the disk. close() removes the file."""

    def __init__(self, n_vertices: int, n_shapes: int) -> None:
        """For so many shapes. Raises ValueError if they will be on the disk and it has no room for them."""
        self._n_bytes = n_vertices * BYTES_PER_VERTEX
        if n_shapes * self._n_bytes > BYTES_IN_MEMORY:
            n_bytes = n_shapes * self._n_bytes
            check_space(Path(tempfile.gettempdir()), n_bytes, "The file of the solved shapes", FEWER)
        self._file = tempfile.SpooledTemporaryFile(max_size=BYTES_IN_MEMORY, prefix="arap-")  # noqa: SIM115
        self._n = 0

    def __len__(self) -> int:
        return self._n

    def append(self, shape: Float32s) -> None:
        """Raises RuntimeError if the disk is full."""
        try:
            self._file.seek(self._n * self._n_bytes)
            self._file.write(np.ascontiguousarray(shape, dtype=np.float32).tobytes())
        except OSError as error:
            raise RuntimeError(
                f"The solved shapes do not fit into the folder for temporary files ({error.strerror}): "
                f"free disk space there, or {FEWER}"
            ) from error
        self._n += 1

    def __getitem__(self, index: int) -> Float32s:
        if not 0 <= index < self._n:
            raise IndexError(index)
        self._file.seek(index * self._n_bytes)
        return np.frombuffer(self._file.read(self._n_bytes), dtype=np.float32).reshape(-1, 3)

    def close(self) -> None:
        """Frees memory and disk."""
        self._file.close()
        self._n = 0
