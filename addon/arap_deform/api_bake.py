# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking an animation of the handles to keyframed shape keys."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from .session import Progress


@dataclass(frozen=True)
class BakeEstimate:
    """What a bake would make."""

    n_keys: int
    n_vertices: int
    bytes_in_file: int
    bytes_in_memory: int

    def __str__(self) -> str:
        """For the panel: '48 keys, 7 MB in the file, 14 MB in memory'."""
        raise NotImplementedError


class BakeJob:
    """A bake that is done in steps, so that an operator can show progress and take Esc in between.

    Nothing in the file changes before finish(), except the current frame and the live key's pose; cancel() brings
    both back.
    """

    @property
    def fraction(self) -> float:
        """Fraction done, 0 to 1."""
        raise NotImplementedError

    @property
    def frame(self) -> int:
        """The frame being solved."""
        raise NotImplementedError

    def step(self, time_limit_s: float = 0.1) -> bool:
        """Solves for about ``time_limit_s`` seconds; True while there is more to do. Call finish() after the last."""
        raise NotImplementedError

    def finish(self) -> list[str]:
        """Writes the keys and their keyframes, goes back to the frame at the start, returns the keys' names."""
        raise NotImplementedError

    def cancel(self) -> None:
        """Everything as before the bake."""
        raise NotImplementedError


def estimate_bake(obj: bpy.types.Object, start: int, end: int, step: int = 1) -> BakeEstimate:
    """How many keys and bytes bake_animation() of the same arguments would make. Raises as it would."""
    raise NotImplementedError


def begin_bake(
    obj: bpy.types.Object,
    start: int,
    end: int,
    step: int = 1,
    prefix: str = "",
    scene: bpy.types.Scene | None = None,
    progress: Progress | None = None,
) -> BakeJob:
    """Checks everything, binds, and returns the job. Arguments as bake_animation(); ``progress`` is for the bind."""
    raise NotImplementedError


def bake_animation(
    obj: bpy.types.Object,
    start: int,
    end: int,
    step: int = 1,
    progress: Progress | None = None,
    prefix: str = "",
    scene: bpy.types.Scene | None = None,
) -> list[str]:
    """Bakes frames start, start + step, ... up to end (always included) to one shape key each.

    At each baked frame exactly that frame's pose shows; in between neighbours blend linearly. Keys of an earlier
    bake with the same prefix are replaced. The live key is muted so that it does not add to them.

    Args:
        prefix: keys are named prefix + frame; '' takes the live key's name and '.'.
        scene: whose frames; None takes the current scene.

    Returns:
        The names of the keys.

    Raises:
        ValueError: end before start, step below 1, absolute keys, linked or shared mesh data, and as solve() does.
        Cancelled: ``progress`` returned False; nothing has changed.
    """
    raise NotImplementedError
