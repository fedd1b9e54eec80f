# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Bake": the pose, or the animation of the handles, to shape keys."""

from __future__ import annotations

import bpy

from ..ui.panels import ArapSubPanel


class ARAP_PT_bake(ArapSubPanel, bpy.types.Panel):
    bl_label = "Bake"
    bl_order = 50

    def draw(self, _context: bpy.types.Context) -> None:
        column = self.layout.column(align=True)
        column.operator("arap.bake_pose", icon="SHAPEKEY_DATA")
        column.operator("arap.bake_animation", icon="RENDER_ANIMATION")
        column.operator("arap.export_mesh_cache", icon="EXPORT")
