# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Pose": the acts, what nothing holds, and what the last solve did."""

from __future__ import annotations

import bpy

from ..core import sessions
from ..core.session_data import Readout
from ..ui.checks import find_posed_object, posed_object
from ..ui.panels import ArapPanel, ArapSubPanel, draw_table, draw_text

STOP_REASONS = {
    "converged": "Converged",
    "max_iterations": "Iteration limit",
    "time_limit": "Time limit",
}


class ARAP_PT_pose(ArapSubPanel, bpy.types.Panel):
    """Pose, pull, solve; and parts of the mesh that nothing holds."""

    bl_idname = "ARAP_PT_pose"
    bl_label = "Pose"
    bl_order = 30

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        _draw_buttons(layout)
        readout = sessions.readout(obj.name_full)
        if readout is not None and (readout.parts_at_rest or readout.loose_vertices):
            box = layout.box()
            draw_text(context, box, unheld_text(readout), "INFO")
            box.operator("arap.select_unheld", text="Select Them", icon="RESTRICT_SELECT_OFF")


class ARAP_PT_readout(ArapPanel, bpy.types.Panel):
    """What the last solve did."""

    bl_idname = "ARAP_PT_readout"
    bl_label = "Last Solve"
    bl_parent_id = "ARAP_PT_pose"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        obj = find_posed_object(context)
        return obj is not None and sessions.readout(obj.name_full) is not None

    def draw(self, context: bpy.types.Context) -> None:
        readout = sessions.readout(posed_object(context).name_full)
        assert readout is not None
        rows = [
            ("Vertices", f"{readout.vertices:,}"),
            ("Free", f"{readout.free_vertices:,}"),
            ("Last update", f"{readout.last_ms:.1f} ms"),
            ("Iterations", str(readout.iterations)),
            ("Energy", f"{readout.energy:.4g}"),
            ("Stopped", STOP_REASONS.get(readout.stop_reason, readout.stop_reason)),
        ]
        draw_table(self.layout, rows)


def unheld_text(readout: Readout) -> str:
    """One sentence on what nothing holds, translated."""
    parts, loose = readout.parts_at_rest, readout.loose_vertices
    if parts and loose:
        return f"Held by nothing, so they stay at rest: {parts} parts and {loose} loose vertices"
    if parts == 1:
        return "Held by nothing, so it stays at rest: 1 part of the mesh"
    if parts:
        return f"Held by nothing, so they stay at rest: {parts} parts of the mesh"
    if loose == 1:
        return "In no face, so it stays at rest: 1 loose vertex"
    return f"In no face, so they stay at rest: {loose} loose vertices"


def _draw_buttons(layout: bpy.types.UILayout) -> None:
    column = layout.column(align=True)
    pose = column.row(align=True)
    pose.scale_y = 1.6
    pose.operator("arap.pose", text="Pose", icon="PLAY")
    row = column.row(align=True)
    row.operator("arap.pull_tool", text="Pull", icon="VIEW_PAN")
    row.operator("arap.solve", text="Solve", icon="FILE_REFRESH")
    column = layout.column(align=True)
    column.operator("arap.reset_handles", text="Reset Handles", icon="LOOP_BACK")
    column.operator("arap.reset_pose", text="Reset Pose", icon="LOOP_BACK")
    column.operator("arap.apply_pose_as_rest", text="Apply Pose as Rest", icon="CHECKMARK")


CLASSES = (ARAP_PT_pose, ARAP_PT_readout)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
