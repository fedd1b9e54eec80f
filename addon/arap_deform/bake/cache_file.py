# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches on disk, frame by frame: MDD and PC2, the two that Blender's Mesh Cache modifier reads. No bpy.

MDD: big-endian. int32 frames, int32 points, float32 seconds of each frame, then float32 x, y, z of all points, frame
after frame. PC2: little-endian. "POINTCACHE2" and a zero, int32 version 1, int32 points, float32 first frame, float32
frames from one sample to the next, int32 samples, then the same.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .estimate import BYTES_PER_VERTEX
from .whole_file import WholeFile, check_space

FORMATS = {".mdd": "MDD", ".pc2": "PC2"}


def format_of(path: Path) -> str:
    """'MDD' or 'PC2', by the suffix. Raises ValueError."""
    try:
        return FORMATS[path.suffix.lower()]
    except KeyError:
        raise ValueError(f"{path.name}: the file name must end in .mdd or .pc2") from None


def header(kind: str, n_points: int, frames: Sequence[int], fps: float) -> bytes:
    """The bytes before the first frame.

    Args:
        kind: 'MDD' or 'PC2'.
        n_points: of every frame.
        frames: their numbers, evenly spaced.
        fps: frames per second; MDD has seconds from the first frame.
    """
    if kind == "MDD":
        seconds = (np.asarray(frames, dtype=np.float64) - frames[0]) / fps
        return struct.pack(">2i", len(frames), n_points) + seconds.astype(">f4").tobytes()
    step = frames[1] - frames[0] if len(frames) > 1 else 1
    return struct.pack("<12s2i2fi", b"POINTCACHE2\0", 1, n_points, frames[0], step, len(frames))


class CacheWriter:
    """Writes a cache, which has its name only when it is complete: see WholeFile."""

    def __init__(self, path: Path, n_points: int, frames: Sequence[int], fps: float) -> None:
        """Begins the file. Arguments as header(); the suffix gives the format.

        Raises:
            ValueError: another suffix, the file cannot be written, or the disk has no room for all frames.
        """
        kind = format_of(path)
        self._dtype = np.dtype(">f4" if kind == "MDD" else "<f4")
        begin = header(kind, n_points, frames, fps)
        self._file = WholeFile(path)
        try:
            check_space(path.parent, len(begin) + len(frames) * n_points * BYTES_PER_VERTEX, str(path))
            self._file.write(begin)
        except BaseException:
            self.discard()
            raise

    def append(self, positions: NDArray[np.floating]) -> None:
        """Adds the (n, 3) positions of the next frame. Raises RuntimeError if the disk is full."""
        self._file.write(positions.astype(self._dtype).tobytes())

    def finish(self) -> None:
        """The file has all frames now, and replaces an older one. Raises RuntimeError if that fails."""
        self._file.finish()

    def discard(self) -> None:
        """Removes the file; after finish() it does nothing."""
        self._file.discard()
