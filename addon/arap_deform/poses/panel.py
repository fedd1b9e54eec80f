# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Poses": the object's pose library; and a menu of the same operators, which lets F3 find them."""

from __future__ import annotations

from typing import Any

import bpy

from ..ui.checks import arap_object
from ..ui.panels import NARROW_FOR_THREE, ArapSubPanel, button_row, draw_text


class ARAP_UL_poses(bpy.types.UIList):
    """The name of a pose, a sign if it has a shape key, and a button that applies it."""

    def draw_item(
        self,
        _context: bpy.types.Context,
        layout: bpy.types.UILayout,
        data: Any,
        pose: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        row = layout.row(align=True)
        row.prop(pose, "name", text="", emboss=False, icon="POSE_HLT")
        keys = data.id_data.data.shape_keys
        if pose.key_name and keys is not None and pose.key_name in keys.key_blocks:
            row.label(text="", icon="SHAPEKEY_DATA")
        row.operator("arap.poses_apply", text="", icon="PLAY", emboss=False).pose = pose.name


class ARAP_PT_poses(ArapSubPanel, bpy.types.Panel):
    bl_label = "Poses"
    bl_order = 30
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        settings = arap_object(context).arap
        row = layout.row()
        row.template_list("ARAP_UL_poses", "", settings, "poses", settings, "active_pose_index", rows=3)
        column = row.column(align=True)
        column.operator("arap.poses_store", text="", icon="ADD")
        column.operator("arap.poses_delete", text="", icon="REMOVE")
        column.separator()
        replace = column.row(align=True)
        replace.enabled = bool(settings.poses)
        replace.operator("arap.poses_store", text="", icon="FILE_REFRESH").is_replacing = True
        if not settings.poses:
            draw_text(context, layout, "Press + to store the places of the handles.", "INFO")
        row = button_row(context, layout, NARROW_FOR_THREE)
        row.operator("arap.poses_apply", text="Apply")
        row.operator("arap.poses_blend", text="Blend")
        row.operator("arap.poses_mirror", text="Mirror")
        layout.operator("arap.poses_to_keys", text="To Shape Keys", icon="SHAPEKEY_DATA")


class ARAP_MT_poses(bpy.types.Menu):
    bl_label = "Poses"

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_REGION_WIN"
        layout.operator("arap.poses_store", icon="ADD")
        layout.operator("arap.poses_apply", icon="PLAY")
        layout.operator("arap.poses_blend")
        layout.operator("arap.poses_mirror", icon="MOD_MIRROR")
        layout.operator("arap.poses_delete", icon="REMOVE")
        layout.separator()
        layout.operator("arap.poses_to_keys", icon="SHAPEKEY_DATA")
