# SPDX-License-Identifier: GPL-3.0-or-later
"""Point caches on disk, frame by frame: MDD and PC2, the two that Blender's Mesh Cache modifier reads. No bpy.

MDD: big-endian. int32 frames, int32 points, float32 seconds of each frame, then float32 x, y, z of all points, frame
after frame. PC2: little-endian. "POINTCACHE2" and a zero, int32 version 1, int32 points, float32 first frame, float32
frames from one sample to the next, int32 samples, then the same.
"""

from __future__ import annotations

import errno
import struct
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

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
    """Writes a .part file and renames it when it is complete, so no incomplete cache has the final name."""

    def __init__(self, path: Path, n_points: int, frames: Sequence[int], fps: float) -> None:
        """Begins the file. Arguments as header(); the suffix gives the format.

        Raises:
            ValueError: another suffix, or the file cannot be written.
        """
        kind = format_of(path)
        self._path = path
        self._part = path.with_name(f"{path.name}.part")
        self._dtype = np.dtype(">f4" if kind == "MDD" else "<f4")
        try:
            if path.is_dir():
                raise IsADirectoryError(errno.EISDIR, "Is a directory")  # the same message on every system
            self._part.unlink(missing_ok=True)  # of a Blender that was ended
            self._file = self._part.open("xb")  # a new file, never the one that a link leads to
            try:
                self._file.write(header(kind, n_points, frames, fps))
            except OSError:
                self.discard()
                raise
        except OSError as error:
            raise ValueError(
                f"{path} cannot be written ({error.strerror}): choose another folder or another name"
            ) from error

    def append(self, positions: NDArray[np.floating]) -> None:
        """Adds the (n, 3) positions of the next frame. Raises RuntimeError if the disk is full."""
        self._try(lambda: self._file.write(positions.astype(self._dtype).tobytes()))

    def finish(self) -> None:
        """Renames the file, which has all frames now, and replaces an older one. Raises RuntimeError if that fails."""
        self._try(self._file.close)
        self._try(lambda: self._part.replace(self._path))

    def discard(self) -> None:
        """Removes the .part file; after finish() it does nothing."""
        with suppress(OSError):
            self._file.close()
        self._part.unlink(missing_ok=True)

    def _try(self, act: Callable[[], object]) -> None:
        try:
            act()
        except OSError as error:
            raise RuntimeError(
                f"{self._path} could not be written ({error.strerror}): free disk space, or choose another folder"
            ) from error
