# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab "ARAP" in the sidebar of the 3D view: its main panel, and what the others share."""

from __future__ import annotations

import textwrap

import bpy

from . import api, sessions
from .operators.common import find_posed_object
from .operators.pose_act import Phase, PoseAct

STOP_REASONS = {
    "converged": "Converged",
    "max_iterations": "Iteration limit",
    "time_limit": "Time limit",
    "cancelled": "Cancelled",
}


class ArapPanel:
    """What all panels of the tab share."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "ARAP"
    layout: bpy.types.UILayout


class ArapSubPanel(ArapPanel):
    """Shown once there is a mesh."""

    bl_parent_id = "ARAP_PT_main"
    bl_order = 2  # below those of other files that are about acts

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return find_posed_object(context) is not None


class ARAP_PT_main(ArapPanel, bpy.types.Panel):
    """State, the acts, and what the last solve did."""

    bl_idname = "ARAP_PT_main"
    bl_label = "ARAP Deform"

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        problem = api.native_problem()
        if problem:
            draw_text(context, layout.box(), problem, "ERROR")
        obj = find_posed_object(context)
        if obj is None:
            draw_text(context, layout, "Select the mesh to pose.", "INFO")
            return
        layout.label(text=obj.name, icon="OUTLINER_OB_MESH")
        act = sessions.acts.get(obj.name)
        if isinstance(act, PoseAct) and not act.is_drag:
            _draw_act(context, layout, act)
        else:
            hint = _next_step(obj)
            if hint and not problem:
                draw_text(context, layout, hint, "INFO")
            _draw_buttons(layout)
        _draw_readout(layout, obj)


def _next_step(obj: bpy.types.Object) -> str:
    """What somebody new does next; '' once everything is there."""
    settings = obj.arap
    if not settings.handles:
        if obj.mode != "EDIT":
            return "Press Tab, select the vertices to move, and add a handle below."
        return "Select the vertices to move, and add a handle below."
    if not settings.pins and len(settings.handles) < 2:
        return "Pin the vertices that shall stay, or the whole mesh moves with its handle."
    if obj.mode == "EDIT":
        return "Press Tab to leave Edit Mode, then Pose."
    return ""


def _draw_buttons(layout: bpy.types.UILayout) -> None:
    column = layout.column(align=True)
    pose = column.row(align=True)
    pose.scale_y = 1.6
    pose.operator("arap.pose", text="Pose", icon="PLAY")
    column.operator("arap.pull_tool", text="Pull", icon="VIEW_PAN")
    column.operator("arap.solve", text="Solve", icon="FILE_REFRESH")
    column = layout.column(align=True)
    column.operator("arap.bake_pose", text="Bake Pose", icon="SHAPEKEY_DATA")
    column.operator("arap.bake_animation", text="Bake Animation", icon="RENDER_ANIMATION")
    column = layout.column(align=True)
    column.operator("arap.reset_pose", text="Reset Pose", icon="LOOP_BACK")
    column.operator("arap.apply_pose_as_rest", text="Apply Pose as Rest", icon="CHECKMARK")


def _draw_act(context: bpy.types.Context, layout: bpy.types.UILayout, act: PoseAct) -> None:
    box = layout.box()
    if act.phase is Phase.BINDING:
        box.label(text=f"Preparing the mesh: {act.bind_fraction:.0%}", icon="SORTTIME")
    else:
        box.label(text="Settled" if act.is_settled else "Following the handles", icon="REC")
        draw_text(context, box, "Move, turn or scale a handle (G, R, S): the mesh follows.", "BLANK1")
    column = box.column(align=True)
    column.scale_y = 1.3
    column.operator("arap.pose_end", text="Keep (Enter)", icon="CHECKMARK").is_kept = True
    column.operator("arap.pose_end", text="Cancel (Esc)", icon="X").is_kept = False


def _draw_readout(layout: bpy.types.UILayout, obj: bpy.types.Object) -> None:
    readout = api.readout(obj)
    if readout is None:
        return
    rows = [
        ("Vertices", f"{readout.vertices:,}"),
        ("Free", f"{readout.free_vertices:,}"),
        ("Last update", f"{readout.last_ms:.1f} ms"),
        ("Iterations", str(readout.iterations)),
        ("Energy", f"{readout.energy:.4g}"),
        ("Stopped", STOP_REASONS.get(readout.stop_reason, readout.stop_reason)),
    ]
    if readout.parts_at_rest:
        rows.append(("Parts at rest", f"{readout.parts_at_rest} (nothing holds them)"))
    if readout.loose_vertices:
        rows.append(("Loose vertices", f"{readout.loose_vertices:,}"))
    split = layout.box().split(factor=0.45)
    names, values = split.column(align=True), split.column(align=True)
    for name, value in rows:
        names.label(text=name)
        values.label(text=value)


def is_following(obj: bpy.types.Object) -> bool:
    """Whether posing or Live has looked for what is wrong, and changes the mesh too often to look again."""
    return bool(sessions.claimed_by(obj.name) or obj.arap.is_live)


def split_column(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    return column


def draw_text(context: bpy.types.Context, layout: bpy.types.UILayout, text: str, icon: str) -> None:
    """A sentence, wrapped to the width of the sidebar: labels do not wrap by themselves."""
    width = max(16, int((context.region.width / context.preferences.system.ui_scale - 60) / 6.2))
    column = layout.column(align=True)
    column.scale_y = 0.8
    for i, line in enumerate(textwrap.wrap(text, width)):
        column.label(text=line, icon=icon if i == 0 else "BLANK1")


def register() -> None:
    bpy.utils.register_class(ARAP_PT_main)


def unregister() -> None:
    bpy.utils.unregister_class(ARAP_PT_main)
