# SPDX-License-Identifier: GPL-3.0-or-later
"""What a modal operator has in Blender's window, until it ends, is cancelled by Blender, or the add-on is disabled."""

from __future__ import annotations

import time
import traceback
from typing import Any

import bpy

from ..scene import redraw

STATUS_AGAIN_S = 0.5  # Blender's transform operators clear the status bar when they end, so it is set this often


class ModalRun:
    """A timer, and a text in the status bar. leave() takes both back."""

    def __init__(self, context: bpy.types.Context, timer_s: float) -> None:
        self._timer = context.window_manager.event_timer_add(timer_s, window=context.window)
        self._workspaces: set[str] = set()
        self._text, self._shown_at = "", 0.0
        _runs.append(self)

    def show_text(self, context: bpy.types.Context, text: str) -> None:
        """In the status bar."""
        now = time.monotonic()
        if context.workspace is not None and (text != self._text or now - self._shown_at >= STATUS_AGAIN_S):
            self._text, self._shown_at = text, now
            self._workspaces.add(context.workspace.name)
            context.workspace.status_text_set(text)

    @property
    def has_left(self) -> bool:
        return self not in _runs

    def leave(self) -> None:
        _runs.remove(self)
        bpy.context.window_manager.event_timer_remove(self._timer)
        for name in self._workspaces:
            workspace = bpy.data.workspaces.get(name)
            if workspace is not None:
                workspace.status_text_set(None)
        redraw.tag_panels()

    def abort(self, message: str = "") -> object:
        """Ends before its time, and leaves. ``message``: why, for the user."""
        raise NotImplementedError


_runs: list[ModalRun] = []


def abort_all(message: str) -> None:
    """To be called before the classes of the operators go: then Blender drops a running operator silently."""
    for run in _runs.copy():
        try:
            run.abort(message)
        except Exception:  # noqa: BLE001 - the others must end, too
            traceback.print_exc()


class ModalOperator:
    """A mixin for operators with a run."""

    _run: Any = None

    def cancel(self, _context: bpy.types.Context) -> None:
        """Blender ends the operator: a file is loaded, the window is closed, or Esc ends the dialog before the run."""
        if self._run is not None:
            self._run.abort()
