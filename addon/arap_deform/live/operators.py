# SPDX-License-Identifier: GPL-3.0-or-later
"""Esc while a mesh that follows is prepared.

A key and no modal operator: while one runs, Blender does not save automatically.
"""

from __future__ import annotations

from typing import Any

import bpy

from ..ui import waiting
from ..ui.checks import allow
from .runs import Run

_items: list[tuple[Any, Any]] = []
"""The key of the add-on: a keymap, and its item."""


def _prepared() -> Run | None:
    """The run whose bind is shown, if Esc may end it."""
    shown = waiting.shown()
    if shown is None or not isinstance(shown[0], Run):
        return None
    wait = shown[0].wait()
    return shown[0] if wait is not None and wait.ends_on_esc else None


class ARAP_OT_follow_cancel(bpy.types.Operator):
    bl_idname = "arap.follow_cancel"
    bl_label = "Cancel Preparing"
    bl_description = "While a mesh that follows is prepared: switch its Follow off. Nothing moves"
    bl_options = {"UNDO", "INTERNAL"}

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        return allow(cls, "" if _prepared() is not None else "No mesh that follows is being prepared")

    def execute(self, _context: bpy.types.Context) -> set[str]:
        run = _prepared()
        obj = run.scene.obj if run is not None else None
        if obj is None:
            return {"CANCELLED"}
        obj.arap.is_live = False
        self.report({"WARNING"}, f"Preparing '{obj.name}' cancelled: Follow is off, and nothing has moved")
        return {"FINISHED"}


def register() -> None:
    if not bpy.app.background:
        keymap = bpy.context.window_manager.keyconfigs.addon.keymaps.new(name="3D View", space_type="VIEW_3D")
        _items.append((keymap, keymap.keymap_items.new(ARAP_OT_follow_cancel.bl_idname, "ESC", "PRESS")))


def unregister() -> None:
    for keymap, item in _items:
        keymap.keymap_items.remove(item)
    _items.clear()
