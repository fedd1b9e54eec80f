# SPDX-License-Identifier: GPL-3.0-or-later
"""ARAP Pull in the toolbar: its keys (also in the status bar), its cursor, its settings. Without it its pins go."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bl_ui.space_toolsystem_common
import bpy

from ..core import sessions
from ..props import preferences
from ..scene.registration import for_each
from ..ui.checks import find_arap_object
from . import draw, pins

IDNAME = "arap.pull"
LOOK_S = 0.25  # while there are temporary pins, a timer looks this often whether the tool is still on

KEYS = (
    "Drag: pull   |   with Shift: turn   |   Ctrl: along the normal   |   Alt: stretch   |   X, Y, Z: axis   |   "
    "Click: pin   |   Ctrl-click: release   |   F: radius"
)
RADIUS = f'preferences.addons["{preferences.ADDON}"].preferences.pull.radius'


class ArapPullTool(bpy.types.WorkSpaceTool):
    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = IDNAME
    bl_label = "ARAP Pull"
    bl_description = (
        "Drag the surface and the mesh follows.\n"
        "\u2022 Click: pin. Ctrl-click: remove the pin.\n"
        "\u2022 Shift: turn. Ctrl: along the normal. X, Y, Z: axis. Alt: stretch.\n"
        "\u2022 F, [ and ]: radius. Ctrl H: make handles and pins."
    )
    bl_icon = str(Path(__file__).resolve().parent.parent / "icons" / "arap.pull")
    bl_cursor = "PAINT_CROSS"
    bl_keymap = (
        ("arap.pull", {"type": "LEFTMOUSE", "value": "PRESS"}, None),
        ("arap.pull", {"type": "LEFTMOUSE", "value": "PRESS", "shift": True}, None),
        ("arap.pull", {"type": "LEFTMOUSE", "value": "PRESS", "ctrl": True}, None),
        # Reached if no mesh is in hand: then a click selects one, and a drag must not move it.
        ("view3d.rotate", {"type": "LEFTMOUSE", "value": "CLICK_DRAG", "any": True}, None),
        ("wm.radial_control", {"type": "F", "value": "PRESS"}, {"properties": [("data_path_primary", RADIUS)]}),
        (
            "wm.context_scale_int",
            {"type": "LEFT_BRACKET", "value": "PRESS", "repeat": True},
            {"properties": [("data_path", RADIUS), ("value", 0.9)]},
        ),
        (
            "wm.context_scale_int",
            {"type": "RIGHT_BRACKET", "value": "PRESS", "repeat": True},
            {"properties": [("data_path", RADIUS), ("value", 1.0 / 0.9)]},
        ),
        ("arap.pull_make_real", {"type": "H", "value": "PRESS", "ctrl": True}, None),
    )

    @staticmethod
    def draw_settings(context: bpy.types.Context, layout: bpy.types.UILayout, _tool: Any) -> None:
        # First: Blender cuts the end of a header off in a narrow view, and the tab names Make Handles.
        layout.operator("arap.pull_make_real", text="Make Handles")
        layout.operator("arap.pull_release", text="Release")
        settings = preferences.pull()
        layout.prop(settings, "radius")
        obj = find_arap_object(context)
        if obj is not None and pins.has_set_pins(obj):
            layout.label(text="Reach: to pins")  # Auto Reach and Reach have no effect
        else:
            row = layout.row(align=True)
            row.prop(settings, "use_auto_reach", toggle=True)
            if not settings.use_auto_reach:
                row.prop(settings, "reach")
        layout.prop(settings, "use_turn", toggle=True)
        if obj is not None:
            row = layout.row(align=True)
            row.label(text="Mirror")
            for axis in "xyz":
                row.prop(obj.data, f"use_mirror_{axis}", text=axis.upper(), toggle=True)

    @staticmethod
    def draw_cursor(context: bpy.types.Context, _tool: Any, xy: tuple[int, int]) -> None:
        draw.draw_cursor(context, xy)


def is_on() -> bool:
    """Whether it is the active tool in any window."""
    return any(_is_on_in(window) for window in bpy.context.window_manager.windows)


def _is_on_in(window: bpy.types.Window) -> bool:
    tool = window.workspace.tools.from_space_view3d_mode("OBJECT", create=False)
    return tool is not None and tool.idname == IDNAME


def draw_keys(self: Any, context: bpy.types.Context) -> None:
    """In the status bar before a drag. A drag, a bake and other operators have texts of their own there."""
    if context.mode != "OBJECT" or sessions.locks or not _is_on_in(context.window):
        return
    if all(operator.bl_idname == "ARAP_OT_pull" for operator in context.window.modal_operators):
        self.layout.label(text=KEYS)


def watch() -> None:
    """Starts a timer that removes the temporary pins when another tool is chosen or the mesh is edited."""
    if not bpy.app.background and not bpy.app.timers.is_registered(_look):
        bpy.app.timers.register(_look, first_interval=LOOK_S, persistent=True)


def _look() -> float | None:
    objects = pins.objects_with_pins()
    has_tool = is_on()

    def look(obj: bpy.types.Object) -> None:
        if not has_tool or obj.mode != "OBJECT":
            obj.arap.pull_pins.clear()
        else:
            pins.forget_stale(obj)

    for_each(objects, look)
    return LOOK_S if has_tool and objects else None


def replaced() -> None:
    """After an undo or the load of a file."""
    if pins.objects_with_pins():
        watch()


def register() -> None:
    if not bpy.app.background:  # there is no toolbar
        bpy.utils.register_tool(ArapPullTool, after={"builtin.transform"}, separator=True)
        bpy.types.STATUSBAR_HT_header.prepend(draw_keys)


def unregister() -> None:
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
    if not bpy.app.background:
        if is_on():  # else Blender goes on drawing its cursor
            bl_ui.space_toolsystem_common.activate_by_id(bpy.context, "VIEW_3D", "builtin.select_box")
        bpy.types.STATUSBAR_HT_header.remove(draw_keys)
        bpy.utils.unregister_tool(ArapPullTool)
