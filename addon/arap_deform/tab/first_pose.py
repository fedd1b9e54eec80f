# SPDX-License-Identifier: GPL-3.0-or-later
"""The five steps to a first pose: which are done, what does the next one, and what keeps it from being done."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from ..scene import pose_key
from ..setup.handle_operators import why_not_edited
from ..setup.pin_operators import why_nothing_to_pin
from ..setup.select_operators import why_not_editable
from ..ui.checks import find_posed_object, is_posed, why_not_object_mode, why_not_solvable


@dataclass(frozen=True)
class Step:
    """One step.

    Attributes:
        text: a few words, in English.
        hint: a sentence or two on how, in English.
        operator: what does it, '' where it is done by hand.
        mode: the mode that the operator goes to, '' for all others.
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
    "arap.pose": why_not_solvable,
}


def is_wanted(obj: bpy.types.Object | None) -> bool:
    """Whether there is something left to learn: no mesh yet, or one that has never been posed."""
    return obj is None or pose_key.find(obj) is None


def steps(obj: bpy.types.Object | None) -> list[Step]:
    """All five, in order; the first one that is not done comes next."""
    handles = () if obj is None else obj.arap.handles
    # A second handle that stays where it is holds as well as a pin.
    has_pin = obj is not None and (bool(obj.arap.pins) or len(handles) > 1)
    is_ready = has_pin and bool(handles)
    is_editing = obj is not None and obj.mode == "EDIT"
    return [
        Step("Select the mesh", "Click it in the view, or add one (Shift A).", obj is not None),
        Step("Enter Edit Mode", "Or press Tab. Vertices are selected there.", is_editing or is_ready, "arap.edit_mesh"),
        Step("Pin what stays", _pin_hint(obj), has_pin, "arap.pin_add"),
        Step(
            "Add a handle",
            "First select the vertices that shall move, those of a hand for example. An empty appears there.",
            bool(handles),
            "arap.handle_add",
        ),
        _last_step(obj, is_ready),
    ]


def _pin_hint(obj: bpy.types.Object | None) -> str:
    if obj is not None and obj.mode == "EDIT" and obj.data.total_vert_sel >= len(obj.data.vertices) > 0:
        # As on a mesh that was added just now: pinned like that, nothing could move.
        return "All vertices are selected now. Drag a box around those that shall stay, a foot for example."
    return "First select its vertices, those of a foot for example."


def _last_step(obj: bpy.types.Object | None, is_ready: bool) -> Step:
    """Posing, or the way to it from the mode that the mesh is in."""
    if obj is None or not is_ready:
        return Step("Pose", "", False, "arap.pose")
    if is_posed(obj):
        return Step("Move the empty", "Click it and press G: the mesh follows. Enter keeps the pose.", False)
    if obj.mode == "EDIT":
        return Step("Leave Edit Mode", "Or press Tab. The mesh is posed in Object Mode.", False, "arap.edit_mesh")
    if obj.mode != "OBJECT":
        hint = "Or choose it in the menu at the top left of the view. The mesh is posed there."
        return Step("Go to Object Mode", hint, False, "object.mode_set", "OBJECT")
    return Step("Pose", "Then click the empty and move it (G): the mesh follows.", False, "arap.pose")


def why_not(context: bpy.types.Context, step: Step) -> str:
    """What keeps a step from being done now, and what to do about it, in English; '' for nothing."""
    if step.operator in WHY_NOT:
        return WHY_NOT[step.operator](context)
    if find_posed_object(context) is None and context.object is not None:
        return why_not_object_mode(context.object)  # a click selects nothing else in other modes
    return ""
