# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Bake": the pose, or the animation of the handles, to shape keys."""

from __future__ import annotations

import bpy

from ..ui.panels import ArapSubPanel


class ARAP_PT_bake(ArapSubPanel, bpy.types.Panel):
    """What stays without the add-on."""

    bl_idname = "ARAP_PT_bake"
    bl_label = "Bake"
    bl_order = 50

    def draw(self, _context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        column.operator("arap.bake_pose", text="Bake Pose", icon="SHAPEKEY_DATA")
        column.operator("arap.bake_animation", text="Bake Animation", icon="RENDER_ANIMATION")
        column.operator("arap.export_mesh_cache", text="Export Mesh Cache", icon="EXPORT")


def register() -> None:
    bpy.utils.register_class(ARAP_PT_bake)


def unregister() -> None:
    bpy.utils.unregister_class(ARAP_PT_bake)
