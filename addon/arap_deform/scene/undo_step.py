# SPDX-License-Identifier: GPL-3.0-or-later
"""Steps of undo that the add-on makes itself, beside those that Blender makes of operators."""

from __future__ import annotations

from contextlib import nullcontext

import bpy

# Of modes: elsewhere a step holds only what that mode edits.
WHOLE_FILE_MODES = {"OBJECT", "POSE", "WEIGHT_PAINT", "VERTEX_PAINT"}


def push(message: str) -> None:
    """Makes a step of undo, named ``message``. Without a window Blender has none, and nothing is done."""
    windows = bpy.context.window_manager.windows
    is_timer = bpy.context.window is None and bool(windows)
    with bpy.context.temp_override(window=windows[0]) if is_timer else nullcontext():
        if bpy.ops.ed.undo_push.poll():
            bpy.ops.ed.undo_push(message=message)


def holds_whole_file() -> bool:
    """Whether a step that is made now holds the whole file, in every window."""
    actives = (window.view_layer.objects.active for window in bpy.context.window_manager.windows)
    return all(active is None or active.mode in WHOLE_FILE_MODES for active in actives)
