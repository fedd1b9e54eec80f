# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Live": the toggle, and what Live is doing."""

from __future__ import annotations

import bpy

from ..scene import versions
from ..ui.checks import posed_object, why_not_live
from ..ui.panels import ArapSubPanel, draw_text
from . import runs

LIVE_HINT = "Tick Live and the mesh follows its handles all the time, also in playback"


class ARAP_PT_live(ArapSubPanel, bpy.types.Panel):
    bl_label = "Live"
    bl_order = 40

    def draw_header(self, context: bpy.types.Context) -> None:
        obj = posed_object(context)
        self.layout.enabled = obj.arap.is_live or not why_not_live(context)
        self.layout.prop(obj.arap, "is_live", text="")

    def draw(self, context: bpy.types.Context) -> None:
        obj = posed_object(context)
        settings = obj.arap
        run = runs.run_of(obj)
        if run is not None and run.is_binding and not run.pause:
            text = f"Preparing: {run.bind_fraction:.0%}"
            versions.draw_progress(self.layout, text, run.bind_fraction)
            draw_text(context, self.layout, "Untick Live to stop", "BLANK1")
        else:
            draw_text(context, self.layout, *_state(context, obj))
        if settings.is_live and runs.render_notice():
            draw_text(context, self.layout, runs.render_notice(), "ERROR")


def _state(context: bpy.types.Context, obj: bpy.types.Object) -> tuple[str, str]:
    if obj.arap.live_problem:
        return obj.arap.live_problem, "ERROR"
    if not obj.arap.is_live:
        return why_not_live(context) or LIVE_HINT, "INFO"
    run = runs.run_of(obj)
    if run is None:  # until the scene is evaluated again
        return "Waiting", "SORTTIME"
    if run.pause:
        return run.pause, "PAUSE"
    return ("Settled" if run.is_settled else "Following the handles"), "REC"
