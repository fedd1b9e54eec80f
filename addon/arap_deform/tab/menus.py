# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu "ARAP" of each mode, and what the menus of the right mouse button have. F3 finds what is in a menu."""

from __future__ import annotations

from typing import Any

import bpy

from ..ui.checks import find_posed_object

PARENTS = ("VIEW3D_MT_object", "VIEW3D_MT_edit_mesh", "VIEW3D_MT_pose", "VIEW3D_MT_paint_weight")
CONTEXT_PARENTS = (
    "VIEW3D_MT_object_context_menu",
    "VIEW3D_MT_edit_mesh_context_menu",
    "VIEW3D_MT_pose_context_menu",
    "VIEW3D_PT_paint_weight_context_menu",  # a panel, which takes additions as menus do
)


class ARAP_MT_main(bpy.types.Menu):
    """All acts; those that cannot be done now are grey."""

    bl_idname = "ARAP_MT_main"
    bl_label = "ARAP"

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_REGION_WIN"  # some of the parents have set it to run without dialogs
        layout.operator("arap.pose", icon="PLAY")
        layout.operator("arap.pull_tool", icon="VIEW_PAN")
        layout.operator("arap.solve", icon="FILE_REFRESH")
        layout.separator()
        layout.operator("arap.bake_pose", icon="SHAPEKEY_DATA")
        layout.operator("arap.bake_animation", icon="RENDER_ANIMATION")
        layout.operator("arap.export_mesh_cache", icon="EXPORT")
        layout.separator()
        layout.operator("arap.edit_mesh", icon="EDITMODE_HLT")
        layout.operator("arap.handle_add", icon="EMPTY_AXIS")
        layout.operator("arap.handle_add_from_empties")
        layout.operator("arap.handle_remove")
        layout.operator("arap.pin_add", icon="PINNED")
        layout.operator("arap.pin_remove")
        layout.operator("arap.select_unheld", icon="RESTRICT_SELECT_OFF")
        layout.separator()
        layout.menu("ARAP_MT_poses", icon="POSE_HLT")
        layout.separator()
        layout.operator("arap.rigid_add", icon="MESH_ICOSPHERE")
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
        layout.operator("arap.reset_handles", icon="LOOP_BACK")
        layout.operator("arap.reset_pose")
        layout.operator("arap.apply_pose_as_rest")


class ARAP_MT_context(bpy.types.Menu):
    """What is done most in the mode at hand."""

    bl_idname = "ARAP_MT_context"
    bl_label = "ARAP"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.operator_context = "INVOKE_REGION_WIN"
        if context.mode == "EDIT_MESH":
            layout.operator("arap.pin_add", text="Pin Selected Vertices", icon="PINNED")
            layout.operator("arap.handle_add", text="Add Handle to Selected Vertices", icon="EMPTY_AXIS")
            layout.operator("arap.select_unheld", text="Select Parts without Pins and Handles")
        elif context.mode == "PAINT_WEIGHT":
            layout.operator("arap.pin_add", text="Pin Vertex Group", icon="PINNED")
        else:
            layout.operator("arap.pose", text="Pose", icon="PLAY")
            layout.operator("arap.pull_tool", text="Pull", icon="VIEW_PAN")
            layout.operator("arap.solve", text="Solve", icon="FILE_REFRESH")
            layout.operator("arap.bake_pose", text="Bake Pose", icon="SHAPEKEY_DATA")
            layout.separator()
            layout.operator("arap.handle_add_from_empties", text="Add Handles from Selected Empties", icon="EMPTY_AXIS")
            layout.operator("arap.reset_handles", text="Reset Handles", icon="LOOP_BACK")
            layout.operator("arap.reset_pose", text="Reset Pose")


def _draw(self: Any, _context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.menu(ARAP_MT_main.bl_idname)


def _draw_in_context(self: Any, context: bpy.types.Context) -> None:
    if find_posed_object(context) is not None:  # lights and cameras have menus too
        self.layout.separator()
        self.layout.menu(ARAP_MT_context.bl_idname)


CLASSES = (ARAP_MT_main, ARAP_MT_context)
ADDITIONS = (*((parent, _draw) for parent in PARENTS), *((parent, _draw_in_context) for parent in CONTEXT_PARENTS))


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    for parent, draw in ADDITIONS:
        getattr(bpy.types, parent).append(draw)


def unregister() -> None:
    for parent, draw in ADDITIONS:
        getattr(bpy.types, parent).remove(draw)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
