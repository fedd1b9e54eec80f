# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender tells the add-on: another file was loaded."""

from __future__ import annotations

import bpy
from bpy.app.handlers import persistent

from . import sessions


@persistent
def _on_load(*_: object) -> None:
    sessions.clear()


def register() -> None:
    bpy.app.handlers.load_post.append(_on_load)


def unregister() -> None:
    if _on_load in bpy.app.handlers.load_post:
        bpy.app.handlers.load_post.remove(_on_load)
    sessions.clear()
