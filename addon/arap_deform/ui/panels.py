# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab "ARAP" in the sidebar of the 3D view: its main panel, and what the sub-panels share.

Sub-panels by ``bl_order``: Pose (without a header) 0, Handle or Pin 10, Bake 20, Poses 30, Attach 35,
Stiffness 40, Display 80, Advanced 90. All but the first are closed.
"""

from __future__ import annotations

import blf
import bpy

from ..core import native, sessions
from .checks import find_arap_object
from .wrapping import wrap

FONT = 0
BESIDE_TEXT = 100.0  # pixels at scale 1 of the sidebar's width: tabs, edges of panels and boxes, the icon
NARROW = 250.0  # pixels at scale 1: in a narrower sidebar two buttons with icons do not fit side by side
NARROW_FOR_THREE = 210.0  # the same of three without
DIALOG = 300.0  # pixels at scale 1 of a dialog's width: Blender's default


class ArapPanel:
    """What all panels of the tab share."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "ARAP"
    layout: bpy.types.UILayout


class ArapSubPanel(ArapPanel):
    """Shown if there is a mesh."""

    bl_parent_id = "ARAP_PT_main"

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return find_arap_object(context) is not None


class ARAP_PT_main(ArapPanel, bpy.types.Panel):
    """The name of the mesh, and an error if there is no solver."""

    bl_label = "ARAP Deform"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        problem = native.problem()
        if problem:
            draw_text(context, layout.box(), problem, "ERROR")
        obj = find_arap_object(context)
        if obj is not None:
            layout.label(text=obj.name, translate=False, icon="OUTLINER_OB_MESH")


def is_following(obj: bpy.types.Object) -> bool:
    """Whether posing or Follow changes the mesh. They report problems themselves, so a panel does not look for them."""
    return bool(sessions.locked_by(obj.session_uid) or obj.arap.use_follow)


def split_column(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def draw_text(
    context: bpy.types.Context, layout: bpy.types.UILayout, text: str, icon: str, least_lines: int = 1
) -> None:
    """A sentence wrapped to the width of the sidebar: Blender's labels do not wrap. ``least_lines``: its height."""
    _draw_lines(layout, _lines(context, text, context.region.width), icon, least_lines)


def draw_text_in_dialog(context: bpy.types.Context, layout: bpy.types.UILayout, text: str, icon: str) -> None:
    """The same in a dialog, whose context has the region where it was called."""
    _draw_lines(layout, _lines(context, text, DIALOG * context.preferences.system.ui_scale), icon)


def _draw_lines(layout: bpy.types.UILayout, lines: list[str], icon: str, least_lines: int = 1) -> None:
    column = layout.column(align=True)
    column.scale_y = 0.8
    for i, line in enumerate(lines + [""] * (least_lines - len(lines))):
        column.label(text=line, translate=False, icon=icon if i == 0 else "BLANK1")


def button_row(context: bpy.types.Context, layout: bpy.types.UILayout, narrow: float = NARROW) -> bpy.types.UILayout:
    """A row of buttons; a column where the sidebar is too narrow for their texts."""
    is_narrow = context.region.width < narrow * context.preferences.system.ui_scale
    return layout.column(align=True) if is_narrow else layout.row(align=True)


def _lines(context: bpy.types.Context, text: str, width: float) -> list[str]:
    """Lines that fit into a label beside its icon. ``width``: in pixels of the sidebar or dialog."""
    scale = context.preferences.system.ui_scale
    blf.size(FONT, context.preferences.ui_styles[0].widget.points * scale)
    return wrap(text, width - BESIDE_TEXT * scale, lambda line: float(blf.dimensions(FONT, line)[0]))


def draw_table(layout: bpy.types.UILayout, rows: list[tuple[str, str]]) -> None:
    """Names and their values."""
    split = layout.split(factor=0.45)
    names, values = split.column(align=True), split.column(align=True)
    for name, value in rows:
        names.label(text=name)
        values.label(text=value, translate=False)
