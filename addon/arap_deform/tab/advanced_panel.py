# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Advanced": the shape key, how bends look, and when a solve stops."""

from __future__ import annotations

import bpy

from ..core import sessions
from ..scene import meshes, remembered, versions
from ..scene.inputs import settings_of
from ..ui.checks import posed_object
from ..ui.panels import ArapSubPanel, split_column

SHOWN_ENERGIES = ("rotation_nodes", "spokes_and_rims")  # scripts may set others, too


class ARAP_PT_advanced(ArapSubPanel, bpy.types.Panel):
    bl_label = "Advanced"
    bl_order = 90
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        settings = obj.arap
        column = split_column(layout)
        key_name = column.row()
        key_name.enabled = not sessions.claimed_by(obj.name_full)  # the act is writing to that key
        key_name.prop(settings, "key_name")
        energies = _labelled(column, "Bending").column(align=True)
        for energy in SHOWN_ENERGIES:
            energies.prop_enum(settings, "energy", energy)
        if settings_of(obj).has_radius:
            column.prop(settings, "rigidity")
            _draw_radius(context, column, obj)
        column = split_column(layout)
        column.prop(settings, "max_iterations")
        column.prop(settings, "accuracy")
        split_column(layout).prop(settings, "join_seams")


def _draw_radius(context: bpy.types.Context, column: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """The length of the radius on this mesh, in the unit of the scene."""
    try:
        size = remembered.diagonal(obj, meshes.drawn_depsgraph(context))
    except ValueError:  # scaled to nothing, which posing reports
        return
    radius = versions.length_text(context.scene, size * obj.arap.rigidity / 100.0)
    _labelled(column, "Radius").label(text=radius, translate=False)


def _labelled(column: bpy.types.UILayout, text: str) -> bpy.types.UILayout:
    """A row with a name where properties have theirs; returns the place of the value."""
    split = column.split(factor=0.4)
    split.use_property_split = False
    name, value = split.row(), split.row()
    name.alignment = "RIGHT"
    name.label(text=text)
    return value
