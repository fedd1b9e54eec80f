# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Bake": the pose, or the animation of the handles, to shape keys."""

from __future__ import annotations

import bpy

from ..scene import baked
from ..ui.checks import arap_object
from ..ui.panels import ArapSubPanel


class ARAP_PT_bake(ArapSubPanel, bpy.types.Panel):
    bl_label = "Bake"
    bl_order = 20
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        if baked.is_shown(arap_object(context)):
            row = self.layout.row(align=True)
            row.scale_y = 1.3
            row.operator("arap.edit_again", icon="GREASEPENCIL")
        column = self.layout.column(align=True)
        column.operator("arap.bake_pose", icon="SHAPEKEY_DATA")
        column.operator("arap.bake_animation", icon="RENDER_ANIMATION")
        column.operator("arap.export_mesh_cache", icon="EXPORT")
