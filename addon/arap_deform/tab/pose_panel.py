# SPDX-License-Identifier: GPL-3.0-or-later
"""What the tab shows at first glance: the next step, Pull, handles and pins, Follow, and their list."""

from __future__ import annotations

import bpy

from ..attach.hosts import host_of
from ..core import sessions
from ..core.naming import listed
from ..follow import runs
from ..pose.free_parts_text import free_parts_text
from ..scene import baked, ui_cache
from ..setup.bone_operators import selected_armatures
from ..setup.panels import draw_controls
from ..ui.checks import find_arap_object, is_posed, why_baked, why_no_follow
from ..ui.panels import ArapPanel, button_row, draw_text
from .next_step import next_step

LINES = 4  # of the next step in a sidebar of the default width: kept free, so that nothing below it jumps


class ARAP_PT_pose(ArapPanel, bpy.types.Panel):
    bl_label = "Pose"
    bl_parent_id = "ARAP_PT_main"
    bl_order = 0
    bl_options = {"HIDE_HEADER"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        _draw_step(context, layout.box())
        obj = find_arap_object(context)
        if obj is not None:
            _draw_beginning(context, layout, obj)
            _draw_following(context, layout, obj)
            draw_controls(layout, obj)
            _draw_notes(context, layout, obj)


def _draw_step(context: bpy.types.Context, box: bpy.types.UILayout) -> None:
    step = next_step(context)
    if step.fraction is None:
        draw_text(context, box, step.text, step.icon, least_lines=LINES)
        return
    box.progress(text=f"{step.text}: {step.fraction:.0%}", translate=False, factor=step.fraction)
    draw_text(context, box, "To stop, press Esc with the mouse over the view.", "BLANK1", least_lines=LINES - 1)


def _draw_beginning(context: bpy.types.Context, layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    first = layout.row()
    first.scale_y = 1.4
    if baked.is_shown(obj):
        first.operator("arap.edit_again", icon="GREASEPENCIL")
    else:
        first.operator("arap.pull_tool", icon="VIEW_PAN")
    column = layout.column(align=True)
    column.operator("arap.edit_mesh", icon="EDITMODE_HLT", depress=obj.mode == "EDIT")
    pair = button_row(context, column)
    pair.operator("arap.handle_add", icon="EMPTY_AXIS")
    pair.operator("arap.pin_add", icon="PINNED")
    host = host_of(obj)
    if host is not None:
        text = f"Select '{host.name}'"
        column.operator("arap.host_select", text=text, translate=False, icon="RESTRICT_SELECT_OFF")
    if selected_armatures(context):
        column.operator("arap.bones_add", icon="BONE_DATA")
    if ui_cache.has_foreign_handles(obj):
        column.operator("arap.handles_copy", icon="DUPLICATE")


def _draw_following(context: bpy.types.Context, layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    column = layout.column(align=True)
    draw_follow(context, column, obj)
    if is_posed(obj):
        pair = button_row(context, column)
        pair.operator("arap.pose_end", text="Keep", icon="CHECKMARK").is_kept = True
        pair.operator("arap.pose_end", text="Cancel", icon="X").is_kept = False
    pair = button_row(context, layout)
    pair.operator("arap.reset", icon="LOOP_BACK")
    pair.operator("arap.apply_pose_as_rest", text="Apply as Rest", icon="CHECKMARK")


def draw_follow(context: bpy.types.Context, layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """The toggle. It can always be switched off, but not while it waits for Edit Again."""
    toggle = layout.row()
    toggle.enabled = not why_baked(obj) and (obj.arap.use_follow or not why_no_follow(context))
    toggle.prop(obj.arap, "use_follow")


def _draw_notes(context: bpy.types.Context, layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """What is seldom there: so nothing of the tab is below it."""
    if obj.arap.use_follow and runs.render_notice():
        draw_text(context, layout, runs.render_notice(), "ERROR")
    stats = sessions.stats(obj.session_uid)
    if stats is not None and stats.outside:
        text = f"Outside of the mesh, so they move nothing: {listed(stats.outside)}"
        draw_text(context, layout, text, "INFO")
    if stats is not None and (stats.parts_at_rest or stats.loose_vertices):
        box = layout.box()
        draw_text(context, box, free_parts_text(stats), "INFO")
        box.operator("arap.select_free_parts", icon="RESTRICT_SELECT_OFF")
