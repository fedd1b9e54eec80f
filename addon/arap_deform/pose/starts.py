# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep and Cancel of a mesh that follows: the state of the scene when that began."""

from __future__ import annotations

import secrets
from contextlib import suppress

import bpy

from ..core import sessions
from ..live.scene import PAUSING_MODES
from ..props import hooks
from ..scene import pose_key
from .result import PoseState, capture_state, restore_state

MOST_STARTS = 4  # of one object: undo may lead back to an earlier one

_starts: dict[int, PoseState] = {}
"""By the number that the object has: so it has that of each step of undo, also under another name. Of a mesh that
followed when its file was opened there is none."""


def has_start(obj: bpy.types.Object) -> bool:
    return _start_of(obj) is not None


def end_following(obj: bpy.types.Object, *, is_kept: bool) -> list[str]:
    """Switches Follow off. Keeps the pose, or puts mesh and handles back to where they were when it was switched on.

    Returns:
        Names of the cages that could not be put back, see restore_state().

    Raises:
        ValueError: that is not known, or as restore_state(). RuntimeError: as restore_state().
    """
    start = _start_of(obj)
    if not is_kept and start is None:
        raise ValueError(f"'{obj.name}' followed when the file was opened: use Reset Handles, or Keep")
    sessions.check_free(obj)
    obj.arap.is_live = False
    return restore_state(obj, start) if not is_kept and start is not None else []


def _on_toggled(obj: bpy.types.Object) -> None:
    if obj.arap.is_live and obj.type == "MESH" and obj.library is None:
        own = [number for number, state in _starts.items() if state.uid == obj.session_uid]
        for number in own[: max(0, len(own) + 1 - MOST_STARTS)]:
            del _starts[number]
        obj.arap.follow_start = 1 + secrets.randbelow(2**31 - 2)
        _starts[obj.arap.follow_start] = capture_state(obj)
        _make_key(obj)


def _make_key(obj: bpy.types.Object) -> None:
    """Makes the live key now, so that it belongs to the same step of undo. If it cannot be, Follow says why."""
    if obj.mode not in PAUSING_MODES and not obj.data.is_editmode:
        with suppress(ValueError):
            pose_key.writable(obj)


def _start_of(obj: bpy.types.Object) -> PoseState | None:
    start = _starts.get(obj.arap.follow_start)
    if start is None or start.uid != obj.session_uid:
        return None  # a copy has the number of the original, and handles of its own
    return start


def forget() -> None:
    """Another file was loaded."""
    _starts.clear()


CALLBACKS = ((hooks.live_toggled, _on_toggled),)


def unregister() -> None:
    forget()
