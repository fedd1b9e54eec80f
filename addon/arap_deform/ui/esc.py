# SPDX-License-Identifier: GPL-3.0-or-later
"""Esc while something is prepared in the background: a mesh that follows its handles, or an attached object.

A key and no modal operator: while one runs, Blender does not save automatically.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import bpy

from ..core import sessions
from ..engine.scene import is_playing
from . import waiting
from .checks import allow
from .waits import Wait

_items: list[tuple[Any, Any]] = []
"""The key of the add-on: a keymap, and its item."""


class EndedByEsc(ABC):
    """A Waiter without a modal operator of its own."""

    @abstractmethod
    def wait(self) -> Wait | None: ...

    @abstractmethod
    def cancel(self) -> str:
        """Ends the work, so that it does not begin again. Returns what the artist is told, '' if it is gone."""


def is_free() -> bool:
    """Whether Esc is nobody else's: a task, or the playback, would take it."""
    return not (sessions.locks or is_playing())


def _prepared() -> EndedByEsc | None:
    """What is shown, if Esc may end it."""
    shown = waiting.shown()
    if shown is None or not isinstance(shown[0], EndedByEsc):
        return None
    wait = shown[0].wait()
    return shown[0] if wait is not None and wait.ends_on_esc else None


class ARAP_OT_preparing_cancel(bpy.types.Operator):
    bl_idname = "arap.preparing_cancel"
    bl_label = "Cancel Preparing"
    bl_description = (
        "While a mesh that follows is prepared: switch its Follow off. While an attached object is prepared: switch "
        "that off. Nothing moves"
    )
    bl_options = {"UNDO", "INTERNAL"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return allow(cls, "" if _prepared() is not None else "Nothing that follows is being prepared")

    def execute(self, _context: bpy.types.Context) -> set[str]:
        prepared = _prepared()
        text = prepared.cancel() if prepared is not None else ""
        if not text:
            return {"CANCELLED"}
        self.report({"WARNING"}, text)
        return {"FINISHED"}


def register() -> None:
    if not bpy.app.background:
        keymap = bpy.context.window_manager.keyconfigs.addon.keymaps.new(name="3D View", space_type="VIEW_3D")
        _items.append((keymap, keymap.keymap_items.new(ARAP_OT_preparing_cancel.bl_idname, "ESC", "PRESS")))


def unregister() -> None:
    for keymap, item in _items:
        keymap.keymap_items.remove(item)
    _items.clear()
