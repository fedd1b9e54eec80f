# SPDX-License-Identifier: GPL-3.0-or-later
"""The five steps to a first pose: which are done, and what does the next one."""

from __future__ import annotations

from dataclasses import dataclass

import bpy

from . import live_key


@dataclass(frozen=True)
class Step:
    """One step.

    Attributes:
        text: a few words, in English.
        hint: a sentence or two on how, in English.
        operator: what does it, '' where it is done by hand.
    """

    text: str
    hint: str
    is_done: bool
    operator: str = ""


def is_wanted(obj: bpy.types.Object | None) -> bool:
    """Whether there is something left to learn: no mesh yet, or one that has never been posed."""
    return obj is None or live_key.find(obj) is None


def steps(obj: bpy.types.Object | None) -> list[Step]:
    """All five, in order; the first one that is not done comes next."""
    if obj is None:
        return _steps(has_mesh=False)
    settings = obj.arap
    return _steps(
        has_mesh=True,
        is_editing=obj.mode == "EDIT",
        # A second handle that stays where it is holds as well as a pin.
        has_pin=bool(settings.pins) or len(settings.handles) > 1,
        has_handle=bool(settings.handles),
    )


def _steps(*, has_mesh: bool, is_editing: bool = False, has_pin: bool = False, has_handle: bool = False) -> list[Step]:
    is_ready = has_pin and has_handle
    if is_editing and is_ready:
        last = Step("Leave Edit Mode", "Or press Tab. The mesh is posed in Object Mode.", False, "arap.edit_mesh")
    else:
        last = Step("Pose", "Then move the empty (G): the mesh follows. Enter keeps the pose.", False, "arap.pose")
    return [
        Step("Select the mesh", "Click it in the view.", has_mesh),
        Step("Enter Edit Mode", "Or press Tab. Vertices are selected there.", is_editing or is_ready, "arap.edit_mesh"),
        Step("Pin what stays", "First select its vertices, those of a foot for example.", has_pin, "arap.pin_add"),
        Step(
            "Add a handle",
            "First select the vertices that shall move, those of a hand for example. An empty appears there.",
            has_handle,
            "arap.handle_add",
        ),
        last,
    ]
