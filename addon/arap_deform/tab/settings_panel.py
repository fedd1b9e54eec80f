# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Settings": what the solver does."""

from __future__ import annotations

import bpy

from ..core import sessions
from ..scene import mesh_size, versions
from ..scene.inputs import settings_of
from ..ui.checks import posed_object
from ..ui.panels import ArapSubPanel, split_column


class ARAP_PT_settings(ArapSubPanel, bpy.types.Panel):
    """What the solver does."""

    bl_idname = "ARAP_PT_settings"
    bl_label = "Settings"
    bl_order = 90
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        settings = obj.arap
        column = split_column(layout)
        key_name = column.row()
        key_name.enabled = not sessions.claimed_by(obj.name_full)  # the pose under way is in that key
        key_name.prop(settings, "key_name", text="Shape Key")
        column.prop(settings, "energy")
        if settings_of(obj).has_radius:
            column.prop(settings, "rigidity")
            _draw_radius(context, column, obj)
        column.prop(settings, "weights", text="Weights")
        column.prop(settings, "initial_guess")
        column = split_column(layout)
        column.prop(settings, "iterations_per_update", text="Iterations")
        column.prop(settings, "max_iterations", text="At Most")
        column.prop(settings, "accuracy")
        column = split_column(layout)
        column.prop(settings, "join_seams")


def _draw_radius(context: bpy.types.Context, column: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """How long the radius is on this mesh, in the unit of the scene."""
    try:
        size = mesh_size.diagonal(obj, context.evaluated_depsgraph_get())
    except ValueError:  # scaled to nothing: posing says so
        return
    split = column.split(factor=0.4)
    name, value = split.row(), split.row()
    name.alignment = "RIGHT"
    name.label(text="Radius")
    value.label(text=versions.length_text(context.scene, size * obj.arap.rigidity / 100.0), translate=False)


def register() -> None:
    bpy.utils.register_class(ARAP_PT_settings)


def unregister() -> None:
    bpy.utils.unregister_class(ARAP_PT_settings)
