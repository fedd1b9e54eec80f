# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "First Pose": five steps that are ticked off until the mesh has a pose, with a button for each."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from ..scene import pose_key
from ..setup.list_operators import why_not_edited, why_nothing_to_pin
from ..setup.select_operators import why_not_editable
from ..ui.checks import find_posed_object, is_posed, why_not_object_mode, why_not_posable
from ..ui.panels import ArapPanel, draw_text


@dataclass(frozen=True)
class Step:
    """One step.

    Attributes:
        text: a few words.
        hint: how to do it, in one or two sentences.
        operator: its name, '' if the user does the step by hand.
        mode: for object.mode_set, '' for all other operators.
    """

    text: str
    hint: str
    is_done: bool
    operator: str = ""
    mode: str = ""


WHY_NOT = {
    "arap.edit_mesh": why_not_editable,
    "arap.pin_add": why_nothing_to_pin,
    "arap.handle_add": why_not_edited,
    "arap.pose": why_not_posable,
}


def is_wanted(obj: bpy.types.Object | None) -> bool:
    """Whether there is no mesh, or the mesh has never been posed."""
    return obj is None or pose_key.find(obj) is None


def steps(obj: bpy.types.Object | None) -> list[Step]:
    """All five, in order. The first one that is not done comes next."""
    handles = () if obj is None else obj.arap.handles
    # A second handle that does not move holds as well as a pin.
    has_pin = obj is not None and (bool(obj.arap.pins) or len(handles) > 1)
    is_ready = has_pin and bool(handles)
    is_editing = obj is not None and obj.mode == "EDIT"
    return [
        Step("Select the mesh", "Click it in the view, or add one (Shift A).", obj is not None),
        Step("Enter Edit Mode", "Or press Tab, to select vertices.", is_editing or is_ready, "arap.edit_mesh"),
        Step("Add Pin", _pin_hint(obj), has_pin, "arap.pin_add"),
        Step(
            "Add Handle",
            "Select the vertices to move, for example a hand. An empty appears there.",
            bool(handles),
            "arap.handle_add",
        ),
        _last_step(obj, is_ready),
    ]


def _pin_hint(obj: bpy.types.Object | None) -> str:
    if obj is not None and obj.mode == "EDIT" and obj.data.total_vert_sel >= len(obj.data.vertices) > 0:
        # As on a new mesh. With all vertices pinned nothing could move.
        return "All vertices are selected now. Drag a box around the vertices to hold, for example a foot."
    return "Select the vertices to hold, for example a foot."


def _last_step(obj: bpy.types.Object | None, is_ready: bool) -> Step:
    """Pose, or the way to it from the mode of the mesh."""
    if obj is None or not is_ready:
        return Step("Pose", "", False, "arap.pose")
    if is_posed(obj):
        return Step("Move the empty", "Click it and press G: the mesh follows. Enter keeps the pose.", False)
    if obj.mode == "EDIT":
        return Step("Leave Edit Mode", "Or press Tab. Pose works in Object Mode.", False, "arap.edit_mesh")
    if obj.mode != "OBJECT":
        hint = "Or choose it in the menu at the top left of the view. Pose works there."
        return Step("Go to Object Mode", hint, False, "object.mode_set", "OBJECT")
    return Step("Pose", "Then click the empty and move it (G): the mesh follows.", False, "arap.pose")


def why_not(context: bpy.types.Context, step: Step) -> str:
    """Why a step cannot be done now, and what to do about it; '' if it can."""
    if step.operator in WHY_NOT:
        return WHY_NOT[step.operator](context)
    if find_posed_object(context) is None and context.object is not None:
        return why_not_object_mode(context.object)  # in other modes a click does not select the mesh
    return ""


class ARAP_PT_first_pose(ArapPanel, bpy.types.Panel):
    bl_label = "First Pose"
    bl_parent_id = "ARAP_PT_main"
    bl_order = 0

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return is_wanted(find_posed_object(context))

    def draw(self, context: bpy.types.Context) -> None:
        shown = steps(find_posed_object(context))
        following = next(step for step in shown if not step.is_done)
        column = self.layout.column()
        for number, step in enumerate(shown, 1):
            row = column.row()
            row.active = step is following
            row.label(text="", icon="CHECKBOX_HLT" if step.is_done else "CHECKBOX_DEHLT")
            text = f"{number}. {step.text}"
            if step.is_done or not step.operator:
                row.label(text=text, translate=False)
            else:
                button = row.operator(step.operator, text=text, translate=False)
                if step.mode:
                    button.mode = step.mode
            if step is following:
                problem = why_not(context, step)
                draw_text(context, column, problem or step.hint, "ERROR" if problem else "BLANK1")
