# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu "ARAP" in Object, Edit, Weight Paint and Pose Mode. Blender's search (F3) finds what is in a menu."""

from __future__ import annotations

import bpy

PARENTS = ("VIEW3D_MT_object", "VIEW3D_MT_edit_mesh", "VIEW3D_MT_paint_weight", "VIEW3D_MT_pose")


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
        layout.separator()
        layout.operator("arap.handle_add", icon="EMPTY_AXIS")
        layout.operator("arap.handle_add_from_empties")
        layout.operator("arap.handle_remove")
        layout.operator("arap.pin_add", icon="PINNED")
        layout.operator("arap.pin_remove")
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


def _draw(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.separator()
    self.layout.menu(ARAP_MT_main.bl_idname)


def register() -> None:
    bpy.utils.register_class(ARAP_MT_main)
    for parent in PARENTS:
        getattr(bpy.types, parent).append(_draw)


def unregister() -> None:
    for parent in PARENTS:
        getattr(bpy.types, parent).remove(_draw)
    bpy.utils.unregister_class(ARAP_MT_main)
