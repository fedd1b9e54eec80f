# SPDX-License-Identifier: GPL-3.0-or-later
"""The one list of handles and pins: which entry is chosen, and what a click on it selects in the view."""

from __future__ import annotations

from typing import Any

import bpy

from ..props import hooks
from ..scene import known, meshes, redraw, versions
from ..scene.registration import for_each
from ..ui.checks import select_alone
from .handles import HANDLES
from .pins import PINS, GroupList, count_rows


def entry_at(obj: bpy.types.Object, row: int) -> Any | None:
    """The handle or pin of a row; None if there is none, as in a damaged file."""
    for entries in (obj.arap.handles, obj.arap.pins):
        if row < len(entries):
            return entries[row]
        row -= len(entries)
    return None


def chosen(obj: bpy.types.Object) -> tuple[GroupList, int] | None:
    """The list of the chosen entry, and its index there; None if there is none."""
    row, n_handles = obj.arap.shown_row, len(obj.arap.handles)
    if entry_at(obj, row) is None:
        return None
    return (HANDLES, row) if row < n_handles else (PINS, row - n_handles)


def take_in_hand(context: bpy.types.Context, handle: Any) -> None:
    """Selects the handle's object alone and makes it active, so that G moves it. In Pose Mode its bone.

    Not if it is hidden, and not if that would end the mode.
    """
    target = handle.target
    if target is None or not target.visible_get():
        return
    if context.mode == "POSE" and target == context.object and handle.bone in target.pose.bones:
        versions.select_bone(target, handle.bone)
    if context.mode != "OBJECT":
        return
    select_alone(context, target)
    if handle.bone and target.type == "ARMATURE":
        target.data.bones.active = target.data.bones.get(handle.bone)


def _on_chosen(obj: bpy.types.Object, row: int) -> None:
    context, entry = bpy.context, entry_at(obj, row)
    if entry is None:
        return
    if row < len(obj.arap.handles):
        take_in_hand(context, entry)
    elif context.mode == "OBJECT" and obj.visible_get():
        for handle in obj.arap.handles:
            if handle.target is not None and handle.target.visible_get():
                handle.target.select_set(False)
        context.view_layer.objects.active = obj


def count_soon(obj: bpy.types.Object) -> None:
    """For drawing, which must change nothing: if rows are missing, has a timer count them."""
    if not _is_miscounted(obj):
        return
    known.add(obj)
    if not bpy.app.timers.is_registered(count_all):
        bpy.app.timers.register(count_all, first_interval=0.0, persistent=True)


def _is_miscounted(obj: bpy.types.Object) -> bool:
    """Whether a script has changed a list, or an older file was opened or appended. Only of what may be changed."""
    settings = obj.arap
    if len(settings.rows) == len(settings.handles) + len(settings.pins):
        return False
    return obj.library is None and not meshes.is_override(obj)


def count_all() -> None:
    """Also after the load of a file."""
    for_each((obj for obj in known.all_objects() if _is_miscounted(obj)), count_rows)
    redraw.tag_panels()


CALLBACKS = ((hooks.row_chosen, _on_chosen),)


def unregister() -> None:
    if bpy.app.timers.is_registered(count_all):
        bpy.app.timers.unregister(count_all)
