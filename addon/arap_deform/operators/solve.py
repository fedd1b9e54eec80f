# SPDX-License-Identifier: GPL-3.0-or-later
"""Solving without the posing act, with or without a window."""

from __future__ import annotations

import bpy

from .. import api
from .common import allow, posed_object, reports_errors, tag_panels, why_not_solvable


class ARAP_OT_solve(bpy.types.Operator):
    bl_idname = "arap.solve"
    bl_label = "ARAP Solve"
    bl_description = "Pose the mesh for the handles where they are now, to the end. Starts from the rest shape"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_solvable(context))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        windows = context.window_manager
        windows.progress_begin(0, 100)
        try:
            readout = api.solve(
                posed_object(context),
                context.evaluated_depsgraph_get(),
                progress=lambda fraction: windows.progress_update(100 * fraction),
            )
        finally:
            windows.progress_end()
        tag_panels(context)
        iterations = "1 iteration" if readout.iterations == 1 else f"{readout.iterations} iterations"
        if readout.stop_reason == "converged":
            self.report({"INFO"}, f"Solved in {iterations}, {readout.last_ms:.0f} ms")
        else:
            self.report(
                {"WARNING"},
                f"Stopped after {iterations}, before the tolerance was met: allow more under Settings, At Most",
            )
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(ARAP_OT_solve)


def unregister() -> None:
    bpy.utils.unregister_class(ARAP_OT_solve)
