# SPDX-License-Identifier: GPL-3.0-or-later
"""Solving without the posing act, with or without a window."""

from __future__ import annotations

import bpy

from .. import api
from .common import allow, posed_object, reports_errors, tag_panels, why_not_solvable


def solve_with_progress(context: bpy.types.Context, obj: bpy.types.Object) -> api.Readout:
    """As api.solve(), with the progress at the cursor."""
    windows = context.window_manager
    windows.progress_begin(0, 100)
    try:
        readout = api.solve(
            obj,
            context.evaluated_depsgraph_get(),
            progress=lambda fraction: windows.progress_update(100 * fraction),
        )
    finally:
        windows.progress_end()
    tag_panels(context)
    return readout


def unsettled_text(readout: api.Readout) -> str:
    """What there is to say where a solve has not converged; '' where it has."""
    if readout.stop_reason == "converged":
        return ""
    iterations = "1 iteration" if readout.iterations == 1 else f"{readout.iterations} iterations"
    return f"Stopped after {iterations}, before the tolerance was met: allow more under Settings, At Most"


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
        readout = solve_with_progress(context, posed_object(context))
        iterations = "1 iteration" if readout.iterations == 1 else f"{readout.iterations} iterations"
        if unsettled_text(readout):
            self.report({"WARNING"}, unsettled_text(readout))
        else:
            self.report({"INFO"}, f"Solved in {iterations}, {readout.last_ms:.0f} ms")
        return {"FINISHED"}


def register() -> None:
    bpy.utils.register_class(ARAP_OT_solve)


def unregister() -> None:
    bpy.utils.unregister_class(ARAP_OT_solve)
