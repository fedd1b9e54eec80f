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
        text: in English.
        operator: what does it, '' where it is done by hand.
    """

    text: str
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
    last = "Leave Edit Mode to pose" if is_editing and is_ready else "Pose, and move the handle (G)"
    return [
        Step("Select the mesh", has_mesh),
        Step("Enter Edit Mode", is_editing or is_ready, "arap.edit_mesh"),
        Step("Select what stays, and pin it", has_pin, "arap.pin_add"),
        Step("Select what moves, and add a handle", has_handle, "arap.handle_add"),
        Step(last, is_done=False, operator="arap.edit_mesh" if is_editing and is_ready else "arap.pose"),
    ]
