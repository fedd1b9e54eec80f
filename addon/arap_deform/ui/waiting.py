# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows in the 3D views what the artist waits for. A timer looks while there is anything."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from ..core.background import Progress
from ..scene import redraw
from .on_screen import draw_wait
from .waits import Wait, Waiter, Waiters

LOOK_S = 0.1

_waiters = Waiters()


def watch(waiter: Waiter) -> None:
    """From now on until it waits for nothing."""
    _waiters.add(waiter)
    if not bpy.app.background and not bpy.app.timers.is_registered(_look):
        bpy.app.timers.register(_look, first_interval=LOOK_S, persistent=True)


def shown() -> tuple[Waiter, Wait] | None:
    """What is shown now."""
    return _waiters.shown


@contextmanager
def at_mouse() -> Iterator[Progress]:
    """For work that Blender waits for: how far it is, beside the mouse. Esc does not end it."""
    windows = bpy.context.window_manager
    windows.progress_begin(0, 100)
    try:
        yield lambda done: windows.progress_update(100 * done)
    finally:
        windows.progress_end()


def _look() -> float | None:
    if _waiters.look():
        redraw.tag_meshes()
    return None if _waiters.is_empty else LOOK_S


def _draw() -> None:
    if _waiters.shown is not None:
        draw_wait(bpy.context, _waiters.shown[1])


DRAWN = ((_draw, "POST_PIXEL"),)


def unregister() -> None:
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
    _waiters.clear()
