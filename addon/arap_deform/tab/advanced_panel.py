# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Advanced": the shape key, how bends look, when a solve stops, and what the last one did."""

from __future__ import annotations

import bpy

from ..core import sessions
from ..core.naming import counted
from ..scene import meshes, ui_cache, versions
from ..scene.snapshot import settings_of
from ..ui.checks import arap_object, find_arap_object
from ..ui.panels import ArapPanel, ArapSubPanel, draw_table, draw_text, split_column

SHOWN_ENERGIES = ("rotation_nodes", "spokes_and_rims")  # scripts may set others, too
STOP_REASONS = {
    "converged": "Converged",
    "max_iterations": "Iteration limit",
    "time_limit": "Time limit",
}


class ARAP_PT_advanced(ArapSubPanel, bpy.types.Panel):
    bl_label = "Advanced"
    bl_order = 90
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = arap_object(context)
        settings = obj.arap
        column = split_column(layout)
        key_name = column.row()
        key_name.enabled = not sessions.locked_by(obj.session_uid)  # the task is writing to that key
        key_name.prop(settings, "key_name")
        column.row().prop(settings, "model", expand=True)
        if settings.model == "solid":
            _whole_row(column).prop(settings, "keep_volume", slider=True)
            column.prop(settings, "cube_size")
            _draw_inside(context, layout, obj)
        else:
            _draw_surface(context, column, obj)
        column = split_column(layout)
        _whole_row(column).prop(settings, "max_iterations")
        column.prop(settings, "accuracy")
        column = layout.column()  # the whole width, for the names
        column.prop(settings, "use_weld")
        column.prop(settings, "use_loose_parts")


class ARAP_PT_stats(ArapPanel, bpy.types.Panel):
    bl_label = "Last Solve"
    bl_parent_id = "ARAP_PT_advanced"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = find_arap_object(context)
        return obj is not None and sessions.stats(obj.session_uid) is not None

    def draw(self, context: bpy.types.Context) -> None:
        stats = sessions.stats(arap_object(context).session_uid)
        assert stats is not None
        rows = [
            ("Vertices", f"{stats.vertices:,}"),
            ("Free", f"{stats.free_vertices:,}"),
            ("Last update", f"{stats.last_ms:.1f} ms"),
            ("Iterations", str(stats.iterations)),
            ("Energy", f"{stats.energy:.4g}"),
            ("Stopped", STOP_REASONS.get(stats.stop_reason, stats.stop_reason)),
        ]
        draw_table(self.layout, rows)


def _draw_inside(context: bpy.types.Context, layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """What a solid makes of parts that are open or thin, once that is known."""
    bound = sessions.get(obj.session_uid)
    if bound is None:
        return
    if not bound.session.has_inside:
        draw_text(context, layout, "This mesh has no inside: Surface bends it better", "INFO")
    elif n := bound.session.n_sheets:
        verb = "stays a surface" if n == 1 else "stay surfaces"
        draw_text(context, layout, f"{counted(n, 'part')} without an inside {verb}", "INFO")


def _draw_surface(context: bpy.types.Context, column: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    energies = _labelled(column, "Bending").column(align=True)
    for energy in SHOWN_ENERGIES:
        energies.prop_enum(obj.arap, "energy", energy)
    if settings_of(obj).has_radius:
        column.prop(obj.arap, "rigidity")
        _draw_radius(context, column, obj)


def _draw_radius(context: bpy.types.Context, column: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    """The length of the radius on this mesh, in the unit of the scene."""
    try:
        size = ui_cache.diagonal(obj, meshes.drawn_depsgraph(context))
    except ValueError:  # scaled to nothing, which posing reports
        return
    radius = versions.length_text(context.scene, size * obj.arap.rigidity / 100.0)
    _labelled(column, "Radius").label(text=radius, translate=False)


def _whole_row(column: bpy.types.UILayout) -> bpy.types.UILayout:
    """For a property whose name is too long for half a row."""
    row = column.row()
    row.use_property_split = False
    return row


def _labelled(column: bpy.types.UILayout, text: str) -> bpy.types.UILayout:
    """A row with a name where properties have theirs; returns the place of the value."""
    split = column.split(factor=0.4)
    split.use_property_split = False
    name, value = split.row(), split.row()
    name.alignment = "RIGHT"
    name.label(text=text)
    return value
