# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab "ARAP" in the sidebar of the 3D view: its main panel, and what the sub-panels share.

Sub-panels by ``bl_order``: First Pose 0, Pins 10, Handles 20, Stiffness 25, Pose 30, Live 40, Poses 45, Bake 50,
Display 80, Advanced 90.
"""

from __future__ import annotations

import blf
import bpy

from ..core import native, sessions
from ..follow.act import Phase, PoseAct
from ..scene import versions
from .checks import find_posed_object
from .wrapping import wrap

FONT = 0
BESIDE_TEXT = 100.0  # pixels at scale 1 of the sidebar's width: tabs, edges of panels and boxes, the icon


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
        return find_posed_object(context) is not None


class ARAP_PT_main(ArapPanel, bpy.types.Panel):
    """The name of the mesh, the posing act if there is one, and an error if there is no solver."""

    bl_label = "ARAP Deform"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        problem = native.problem()
        if problem:
            draw_text(context, layout.box(), problem, "ERROR")
        obj = find_posed_object(context)
        if obj is not None:
            layout.label(text=obj.name, translate=False, icon="OUTLINER_OB_MESH")
            act = sessions.acts.get(obj.name_full)
            if isinstance(act, PoseAct) and not act.is_drag:
                _draw_act(context, layout, act)


def _draw_act(context: bpy.types.Context, layout: bpy.types.UILayout, act: PoseAct) -> None:
    box = layout.box()
    if act.phase is Phase.BINDING:
        versions.draw_progress(box, f"Preparing: {act.bind_fraction:.0%}", act.bind_fraction)
    else:
        box.label(text="Settled" if act.is_settled else "Following the handles", icon="REC")
        draw_text(context, box, "Move, rotate or scale a handle (G, R, S): the mesh follows.", "BLANK1")
    column = box.column(align=True)
    column.scale_y = 1.3
    column.operator("arap.pose_end", text="Keep (Enter)", icon="CHECKMARK").is_kept = True
    column.operator("arap.pose_end", text="Cancel (Esc)", icon="X").is_kept = False


def is_following(obj: bpy.types.Object) -> bool:
    """Whether posing or Live changes the mesh. They report problems themselves, so a panel does not look for them."""
    return bool(sessions.claimed_by(obj.name_full) or obj.arap.is_live)


def split_column(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def draw_text(context: bpy.types.Context, layout: bpy.types.UILayout, text: str, icon: str) -> None:
    """A sentence wrapped to the width of the sidebar: Blender's labels do not wrap."""
    column = layout.column(align=True)
    column.scale_y = 0.8
    for i, line in enumerate(_lines(context, text)):
        column.label(text=line, translate=False, icon=icon if i == 0 else "BLANK1")


def _lines(context: bpy.types.Context, text: str) -> list[str]:
    """Lines that fit into a label of the sidebar beside its icon."""
    scale = context.preferences.system.ui_scale
    versions.set_text_size(FONT, context.preferences.ui_styles[0].widget.points * scale)
    return wrap(text, context.region.width - BESIDE_TEXT * scale, lambda line: float(blf.dimensions(FONT, line)[0]))


def draw_table(layout: bpy.types.UILayout, rows: list[tuple[str, str]]) -> None:
    """Names and their values."""
    split = layout.split(factor=0.45)
    names, values = split.column(align=True), split.column(align=True)
    for name, value in rows:
        names.label(text=name)
        values.label(text=value, translate=False)
