# SPDX-License-Identifier: GPL-3.0-or-later
"""Keep and Cancel of a mesh that follows: the state of the scene when that began."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from ..core import sessions
from ..props import hooks
from .result import PoseState, capture_state, restore_state

_starts: dict[str, PoseState] = {}
"""By name of the object. Of a mesh that followed when its file was opened there is none."""


def has_start(obj: bpy.types.Object) -> bool:
    return obj.name_full in _starts


def end_following(obj: bpy.types.Object, *, is_kept: bool) -> None:
    """Switches Follow off. Keeps the pose, or puts mesh and handles back to where they were when it was switched on.

    Raises:
        ValueError: that is not known, or as restore_state(). RuntimeError: as restore_state().
    """
    start = _starts.get(obj.name_full)
    if not is_kept and start is None:
        raise ValueError(f"'{obj.name}' followed when the file was opened: use Reset, or Keep")
    sessions.check_free(obj.name)
    obj.arap.is_live = False
    if not is_kept and start is not None:
        restore_state(obj, start)


def _on_toggled(obj: bpy.types.Object) -> None:
    if obj.arap.is_live and obj.type == "MESH" and obj.library is None:
        _starts[obj.name] = capture_state(obj)


@persistent
def _on_load(*_: object) -> None:
    _starts.clear()


CALLBACKS = ((hooks.live_toggled, _on_toggled), (bpy.app.handlers.load_post, _on_load))


def unregister() -> None:
    _starts.clear()
