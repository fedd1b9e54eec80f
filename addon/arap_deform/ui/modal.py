# SPDX-License-Identifier: GPL-3.0-or-later
"""What a modal operator has in Blender's window: a timer, and a text in the status bar."""

from __future__ import annotations

import time

import bpy

from ..scene import redraw

STATUS_AGAIN_S = 0.5  # Blender's transform operators clear the status bar when they end, so it is set this often


class Modal:
    """Begins with the timer; end() takes timer and text back."""

    def __init__(self, context: bpy.types.Context, timer_s: float) -> None:
        self._timer = context.window_manager.event_timer_add(timer_s, window=context.window)
        self._workspaces: set[str] = set()
        self._text, self._shown_at = "", 0.0

    def show_status(self, context: bpy.types.Context, text: str) -> None:
        now = time.monotonic()
        if context.workspace is not None and (text != self._text or now - self._shown_at >= STATUS_AGAIN_S):
            self._text, self._shown_at = text, now
            self._workspaces.add(context.workspace.name)
            context.workspace.status_text_set(text)

    def end(self) -> None:
        bpy.context.window_manager.event_timer_remove(self._timer)
        for name in self._workspaces:
            workspace = bpy.data.workspaces.get(name)
            if workspace is not None:
                workspace.status_text_set(None)
        redraw.tag_panels()
