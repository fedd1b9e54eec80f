# SPDX-License-Identifier: GPL-3.0-or-later
"""The chosen entry of the list of pins, handles and bones, and what a click on it selects in the view."""

from __future__ import annotations

from typing import TYPE_CHECKING

import bpy

from ..props import hooks
from ..scene import versions
from ..ui.checks import select_alone

if TYPE_CHECKING:
    from ..props.controls import ArapControl


def chosen(obj: bpy.types.Object) -> ArapControl | None:
    """None if the list is empty, or in a damaged file."""
    index = obj.arap.active_control_index
    return obj.arap.controls[index] if index < len(obj.arap.controls) else None


def select_target(context: bpy.types.Context, handle: ArapControl) -> None:
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


def _on_chosen(obj: bpy.types.Object, control: ArapControl) -> None:
    context = bpy.context
    if not control.is_pin:
        select_target(context, control)
    elif context.mode == "OBJECT" and obj.visible_get():
        for handle in obj.arap.handles:
            if handle.target is not None and handle.target.visible_get():
                handle.target.select_set(False)
        context.view_layer.objects.active = obj


CALLBACKS = ((hooks.control_chosen, _on_chosen),)
