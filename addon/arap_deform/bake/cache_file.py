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
    """'MDD' or 'PC2', by the end of the name. Raises ValueError."""
    try:
        return FORMATS[path.suffix.lower()]
    except KeyError:
        raise ValueError(f"{path.name} is neither .mdd nor .pc2: give the cache one of these ends") from None


def header(kind: str, n_points: int, frames: Sequence[int], fps: float) -> bytes:
    """What stands before the first frame.

    Args:
        kind: 'MDD' or 'PC2'.
        n_points: of every frame.
        frames: their numbers, evenly spaced.
        fps: frames a second; MDD counts seconds from the first frame.
    """
    if kind == "MDD":
        seconds = (np.asarray(frames, dtype=np.float64) - frames[0]) / fps
        return struct.pack(">2i", len(frames), n_points) + seconds.astype(">f4").tobytes()
    step = frames[1] - frames[0] if len(frames) > 1 else 1
    return struct.pack("<12s2i2fi", b"POINTCACHE2\0", 1, n_points, frames[0], step, len(frames))


class CacheWriter:
    """Writes a cache beside its place and puts it there once it is whole: a half one is never found under its name."""

    def __init__(self, path: Path, n_points: int, frames: Sequence[int], fps: float) -> None:
        """Begins the file; as header(), the format by the end of the name.

        Raises:
            ValueError: another end, or the file cannot be written there.
        """
        kind = format_of(path)
        self._path = path
        self._part = path.with_name(f"{path.name}.part")
        self._n_points = n_points
        self._n_left = len(frames)
        self._dtype = np.dtype(">f4" if kind == "MDD" else "<f4")
        try:
            if path.is_dir():
                raise IsADirectoryError(errno.EISDIR, "Is a directory")  # one message for all of them
            self._file = self._part.open("wb")
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
        """Adds (n, 3) positions. Raises RuntimeError where the disk is full."""
        if positions.shape != (self._n_points, 3) or not self._n_left:
            raise ValueError(
                f"A frame of shape {positions.shape} does not fit into {self._path}: "
                f"{self._n_left} frames of shape ({self._n_points}, 3) are left"
            )
        self._n_left -= 1
        self._try(lambda: self._file.write(positions.astype(self._dtype).tobytes()))

    def finish(self) -> None:
        """Puts the file to its place, over an older one. Raises RuntimeError where that fails, or frames lack."""
        if self._n_left:
            raise RuntimeError(f"{self._path} lacks {self._n_left} frames: add them first")
        self._try(self._file.close)
        self._try(lambda: self._part.replace(self._path))

    def discard(self) -> None:
        """Takes back what was written; after finish() it does nothing."""
        with suppress(OSError):
            self._file.close()
        self._part.unlink(missing_ok=True)

    def _try(self, act: Callable[[], object]) -> None:
        try:
            act()
        except OSError as error:
            raise RuntimeError(
                f"{self._path} could not be written ({error.strerror}): make room, or choose another place"
            ) from error
