# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "Pins": the list of pins."""

from __future__ import annotations

from typing import Any

import bpy

from ..scene import empty_groups
from ..ui.checks import find_posed_object, posed_object
from ..ui.panels import ArapSubPanel, draw_list, is_following, split_column
from .group_buttons import draw_group_buttons


class ARAP_UL_pins(bpy.types.UIList):
    """Pins: on or off, and the vertex group."""

    def draw_item(
        self,
        context: bpy.types.Context,
        layout: bpy.types.UILayout,
        _data: Any,
        pin: Any,
        _icon: int,
        _active_data: Any,
        _active_property: str,
    ) -> None:
        obj = find_posed_object(context)
        lack = "" if obj is None else lack_of_group(obj, pin.name)
        row = layout.row(align=True)
        row.prop(pin, "is_enabled", text="")
        label = row.row()
        label.active = pin.is_enabled
        label.alert = bool(lack)
        text = f"{pin.name} ({lack})" if lack else pin.name
        label.label(text=text, translate=False, icon="PINNED")


class ARAP_PT_pins(ArapSubPanel, bpy.types.Panel):
    """The list of pins."""

    bl_idname = "ARAP_PT_pins"
    bl_label = "Pins"
    bl_order = 10

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        obj = posed_object(context)
        settings = obj.arap
        draw_list(layout, settings, "ARAP_UL_pins", "pins", "active_pin_index", "arap.pin_add", "arap.pin_remove")
        if settings.active_pin_index < len(settings.pins):
            pin = settings.pins[settings.active_pin_index]
            split_column(layout).prop_search(pin, "name", obj, "vertex_groups", text="Group")
            draw_group_buttons(layout, obj, pin.name)
        layout.operator(
            "arap.pin_add",
            text="Pin Selected Vertices" if obj.mode == "EDIT" else "Pin Vertex Group",
            icon="PINNED",
        )


def lack_of_group(obj: bpy.types.Object, group: str) -> str:
    """Why a pinned group holds nothing, '' where it does."""
    if group not in obj.vertex_groups:
        return "no such group"
    return "no weights" if not is_following(obj) and empty_groups.is_empty(obj, group) else ""


CLASSES = (ARAP_UL_pins, ARAP_PT_pins)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
