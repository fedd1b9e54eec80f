# SPDX-License-Identifier: GPL-3.0-or-later
"""The frames of a bake, the size of its keys, and how well the keys fit the frames. No bpy."""

from __future__ import annotations

from dataclasses import dataclass

from ..core.naming import counted

BYTES_PER_VERTEX = 12  # of a shape key, and of a frame of a cache
LAST_FRAME = 1048574  # of Blender
MOST_SEARCHED = 10_000  # frames for the fewest keys: the search takes a table of all pairs, here of 100 MB


@dataclass(frozen=True)
class BakeEstimate:
    """The largest number of keys that a bake can make. Blender holds them twice in memory: data and evaluated copy."""

    n_keys: int
    n_vertices: int

    @property
    def bytes_in_file(self) -> int:
        return self.n_keys * self.n_vertices * BYTES_PER_VERTEX

    @property
    def bytes_in_memory(self) -> int:
        return 2 * self.bytes_in_file

    def __str__(self) -> str:
        """'48 keys, 7 MB in the file, 14 MB in memory'."""
        sizes = size_text(self.bytes_in_file), size_text(self.bytes_in_memory)
        return "{}, {} in the file, {} in memory".format(counted(self.n_keys, "key"), *sizes)


@dataclass(frozen=True)
class Fit:
    """How well the keys of a bake fit its frames.

    Attributes:
        n_frames: solved frames.
        n_keys: keys made of them.
        largest_distance: of any vertex in any solved frame from its place by the keys, in world units.
        size: diagonal of the mesh's box at rest, in world units.
    """

    n_frames: int
    n_keys: int
    largest_distance: float
    size: float

    def __str__(self) -> str:
        """'9 keys for 48 frames, largest error 0.080 % of the size', or '48 keys' if every frame has one."""
        if self.n_keys == self.n_frames:
            return counted(self.n_keys, "key")
        percent = 100.0 * self.largest_distance / self.size if self.size else 0.0
        return f"{self.n_keys} keys for {self.n_frames} frames, largest error {percent:.3f} % of the size"


def check_range(start: int, end: int, step: int) -> None:
    """Raises ValueError if there are no frames to solve."""
    if step < 1:
        raise ValueError(f"step = {step}, must be 1 or more")
    if end < start:
        raise ValueError(f"The last frame {end} is before the first, {start}: swap them")
    if start < -LAST_FRAME or end > LAST_FRAME:
        frame = end if end > LAST_FRAME else start
        raise ValueError(f"Blender has no frame {frame}: its frames are {-LAST_FRAME} to {LAST_FRAME}")


def check_search(n: int) -> None:
    """Raises ValueError if the fewest keys of so many frames cannot be found."""
    if n > MOST_SEARCHED:
        raise ValueError(f"Fewest Keys takes up to {MOST_SEARCHED} frames, not {n}: raise Step, or bake in parts")


def n_frames(start: int, end: int, step: int) -> int:
    """How many frames_of() gives. Raises ValueError."""
    check_range(start, end, step)
    return -(-(end - start) // step) + 1


def frames_of(start: int, end: int, step: int) -> list[int]:
    """The frames that a bake solves: every ``step``-th, and always ``end``. Raises ValueError."""
    check_range(start, end, step)
    return [*range(start, end, step), end]


def size_text(n_bytes: float) -> str:
    """'7 MB'."""
    for unit in ("B", "kB", "MB"):
        if n_bytes < 1000:
            return f"{n_bytes:.0f} {unit}"
        n_bytes = n_bytes / 1000
    return f"{n_bytes:.1f} GB"
