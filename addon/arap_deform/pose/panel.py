# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Pose": the acts, parts that nothing holds, and what the last solve did."""

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
    bl_label = "Pose"
    bl_order = 30

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        _draw_buttons(layout)
        readout = sessions.readout(posed_object(context).name_full)
        if readout is not None and (readout.parts_at_rest or readout.loose_vertices):
            box = layout.box()
            draw_text(context, box, unheld_text(readout), "INFO")
            box.operator("arap.select_unheld", icon="RESTRICT_SELECT_OFF")


class ARAP_PT_readout(ArapPanel, bpy.types.Panel):
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
    """One sentence on the parts and loose vertices that have no pin or handle."""
    counts = ((readout.parts_at_rest, "part", "parts"), (readout.loose_vertices, "loose vertex", "loose vertices"))
    found = [f"{n} {one if n == 1 else many}" for n, one, many in counts if n]
    is_one = readout.parts_at_rest + readout.loose_vertices == 1
    verbs = ("has", "does") if is_one else ("have", "do")
    return "{} {} no pin or handle and {} not move".format(" and ".join(found), *verbs)


def _draw_buttons(layout: bpy.types.UILayout) -> None:
    column = layout.column(align=True)
    pose = column.row(align=True)
    pose.scale_y = 1.6
    pose.operator("arap.pose", icon="PLAY")
    column.operator("arap.pull_tool", icon="VIEW_PAN")
    column = layout.column(align=True)
    column.operator("arap.reset_handles", icon="LOOP_BACK")
    column.operator("arap.reset_pose", icon="LOOP_BACK")
    column.operator("arap.apply_pose_as_rest", icon="CHECKMARK")
