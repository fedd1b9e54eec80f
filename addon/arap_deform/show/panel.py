# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Display": what the overlay draws."""

from __future__ import annotations

import bpy

from ..ui.checks import arap_object
from ..ui.panels import ArapSubPanel, draw_text, split_column


class ARAP_PT_display(ArapSubPanel, bpy.types.Panel):
    bl_label = "Display"
    bl_order = 80
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        settings = arap_object(context).arap.overlay
        column = layout.column(align=True)
        column.prop(settings, "show_pins", icon="PINNED")
        column.prop(settings, "show_handles", icon="EMPTY_AXIS")
        column.prop(settings, "show_strain", icon="MOD_MESHDEFORM")
        if arap_object(context).arap.model == "solid":
            column.prop(settings, "show_cubes", icon="MOD_LATTICE")
        split_column(layout).prop(arap_object(context).arap, "handle_size", text="Handle Size")
        limit = split_column(layout)
        limit.active = settings.show_strain
        limit.prop(settings, "strain_limit")
        if not context.space_data.overlay.show_overlays:
            draw_text(context, layout, "Overlays are off in this view", "INFO")
