# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu "ARAP" of each mode, and its short form in the context menus. F3 finds what is in a menu."""

from __future__ import annotations

from typing import Any

import bpy

from ..ui.checks import find_arap_object
from .pose_panel import draw_follow

PARENTS = ("VIEW3D_MT_object", "VIEW3D_MT_edit_mesh", "VIEW3D_MT_pose", "VIEW3D_MT_paint_weight")
CONTEXT_PARENTS = (
    "VIEW3D_MT_object_context_menu",
    "VIEW3D_MT_edit_mesh_context_menu",
    "VIEW3D_MT_pose_context_menu",
    "VIEW3D_PT_paint_weight_context_menu",  # a panel, which takes additions as menus do
)


class ARAP_MT_main(bpy.types.Menu):
    bl_label = "ARAP"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_REGION_WIN"  # some parent menus run operators without their dialogs
        layout.operator("arap.pull_tool", icon="VIEW_PAN")
        layout.operator("arap.pose", icon="PLAY")
        obj = find_arap_object(context)
        if obj is not None:
            draw_follow(context, layout, obj)
        layout.operator("arap.solve", icon="FILE_REFRESH")
        layout.separator()
        layout.operator("arap.bake_pose", icon="SHAPEKEY_DATA")
        layout.operator("arap.bake_animation", icon="RENDER_ANIMATION")
        layout.operator("arap.export_mesh_cache", icon="EXPORT")
        layout.operator("arap.edit_again")
        layout.separator()
        layout.operator("arap.edit_mesh", icon="EDITMODE_HLT")
        layout.operator("arap.handle_add", icon="EMPTY_AXIS")
        layout.operator("arap.bones_add", icon="BONE_DATA")
        layout.operator("arap.handles_copy")
        layout.operator("arap.pin_add", icon="PINNED")
        layout.operator("arap.control_remove")
        layout.operator("arap.select_free_parts", icon="RESTRICT_SELECT_OFF")
        layout.separator()
        layout.operator("arap.attach", icon="MOD_CLOTH")
        layout.operator("arap.detach")
        layout.operator("arap.host_select")
        layout.operator("arap.stand_in_make", icon="MOD_LATTICE")
        layout.operator("arap.stand_in_remove")
        layout.operator("arap.cage_make", icon="MOD_MESHDEFORM")
        layout.separator()
        layout.menu("ARAP_MT_poses", icon="POSE_HLT")
        layout.separator()
        layout.operator("arap.stiffness_add", text="Make Rigid", icon="MESH_ICOSPHERE").use_rigid = True
        layout.operator("arap.stiffness_add")
        layout.operator("arap.stiffness_remove")
        layout.separator()
        layout.operator("arap.group_paint", icon="BRUSH_DATA")
        layout.operator("arap.group_soften")
        layout.operator("arap.group_select")
        layout.separator()
        layout.operator("arap.pull_make_real")
        layout.operator("arap.pull_release")
        layout.separator()
        layout.operator("arap.reset", icon="LOOP_BACK")
        layout.operator("arap.apply_pose_as_rest")


class ARAP_MT_context(bpy.types.Menu):
    bl_label = "ARAP"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_REGION_WIN"
        if context.mode == "EDIT_MESH":
            layout.operator("arap.pin_add", icon="PINNED")
            layout.operator("arap.handle_add", icon="EMPTY_AXIS")
            layout.operator("arap.select_free_parts")
        elif context.mode == "PAINT_WEIGHT":
            layout.operator("arap.pin_add", icon="PINNED")
        else:
            layout.operator("arap.pull_tool", icon="VIEW_PAN")
            layout.operator("arap.pose", icon="PLAY")
            layout.operator("arap.solve", icon="FILE_REFRESH")
            layout.operator("arap.bake_pose", icon="SHAPEKEY_DATA")
            layout.separator()
            layout.operator("arap.handle_add", icon="EMPTY_AXIS")
            layout.operator("arap.bones_add", icon="BONE_DATA")
            layout.operator("arap.reset", icon="LOOP_BACK")


def _draw(self: Any, _context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.menu("ARAP_MT_main")


def _draw_in_context(self: Any, context: bpy.types.Context) -> None:
    if find_arap_object(context) is not None:  # lights and cameras have menus too
        self.layout.separator()
        self.layout.menu("ARAP_MT_context")


ADDITIONS = (*((parent, _draw) for parent in PARENTS), *((parent, _draw_in_context) for parent in CONTEXT_PARENTS))


def register() -> None:
    for parent, draw in ADDITIONS:
        getattr(bpy.types, parent).append(draw)


def unregister() -> None:
    for parent, draw in ADDITIONS:
        getattr(bpy.types, parent).remove(draw)
