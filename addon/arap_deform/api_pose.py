# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing: sessions, one update, solving to the end, and what becomes of the pose."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import bpy

from .session import Progress, Readout, Session

if TYPE_CHECKING:
    from numpy.typing import NDArray


@dataclass(frozen=True)
class SessionInput:
    """Everything a session needs, read from the scene; holds no Blender data, so any thread may use it."""

    object_name: str


@dataclass(frozen=True)
class PoseState:
    """What the modal act gives back on Esc: the key's values and slider, and the handles' transforms. No Blender data."""

    object_name: str


def session_input(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> SessionInput:
    """Reads mesh, groups and settings. Main thread only.

    Raises:
        ValueError: not a mesh, in Edit Mode, linked or shared data, absolute keys, singular scale, a pin or handle
            without its group or object, nothing pinned or handled.
    """
    raise NotImplementedError


def build_session(inputs: SessionInput, progress: Progress | None = None) -> Session:
    """Binds and factorizes. Touches no Blender data: may run in a worker thread; ``progress`` is called there."""
    raise NotImplementedError


def adopt_session(obj: bpy.types.Object, inputs: SessionInput, session: Session) -> None:
    """Makes ``session`` the object's live one and starts it from the pose shown. Main thread only."""
    raise NotImplementedError


def prepare_session(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None, progress: Progress | None = None
) -> Session:
    """The object's live session, made, or brought up to date, where needed: session_input, build_session, adopt_session.

    A session that fits is kept; changed groups only factorize again; a changed mesh, scale or setting binds again.
    """
    raise NotImplementedError


def check_live(obj: bpy.types.Object, is_thorough: bool = False) -> str:
    """Why the object's live session no longer fits the scene, one sentence; '' while it does.

    Args:
        is_thorough: compare topology, rest shape and weights too (milliseconds); False: counts, scale and
            settings (microseconds).
    """
    raise NotImplementedError


def end_session(obj_or_name: bpy.types.Object | str) -> None:
    """Forgets the live session, if any. The pose stays."""
    raise NotImplementedError


def readout(obj_or_name: bpy.types.Object | str) -> Readout | None:
    """What the last solve of this object did, for the panel; None before the first."""
    raise NotImplementedError


def update_pose(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph | None = None,
    *,
    iterations: int | None = None,
    initial_guess: str | None = None,
    time_limit_s: float | None = None,
) -> Readout:
    """One live update: reads the handles, solves a few iterations, writes the key.

    Needs a live session (prepare_session or adopt_session). ``readout.stop_reason`` is "converged" when nothing is
    left to do at these handles.

    Raises:
        RuntimeError: no live session, or the mesh or scale has changed under it (the session has then ended).
    """
    raise NotImplementedError


def solve(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None, progress: Progress | None = None
) -> Readout:
    """Poses the mesh for the handles where they are now, to convergence, and writes the key.

    Starts from rest with the guess from the handles' rotations: the same file gives the same result.
    """
    raise NotImplementedError


def bake_pose(obj: bpy.types.Object, name: str = "Pose") -> bpy.types.ShapeKey:
    """Copies the pose shown by the live key to a new key (value 0); the live key stays."""
    raise NotImplementedError


def reset_pose(obj: bpy.types.Object) -> None:
    """Puts the live key, and the session, back to rest. Handles stay where they are: see reset_handles."""
    raise NotImplementedError


def apply_pose_as_rest(obj: bpy.types.Object) -> None:
    """Makes the pose the new rest shape: Basis takes it, other keys keep their offsets, handles are at rest here."""
    raise NotImplementedError


def capture_state(obj: bpy.types.Object) -> PoseState:
    """What restore_state() brings back."""
    raise NotImplementedError


def restore_state(obj: bpy.types.Object, state: PoseState) -> None:
    """Back to ``state``: the key (removed where there was none), its slider, the handles' transforms, the session."""
    raise NotImplementedError
