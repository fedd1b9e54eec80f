# SPDX-License-Identifier: GPL-3.0-or-later
"""Pins of an object: added."""

from __future__ import annotations

import bpy

from ..scene import groups, meshes, preserve_shape
from ..scene.groups import VertexIndices
from .controls import new_control


def add_pin(obj: bpy.types.Object, vertices: VertexIndices, name: str = "Pin") -> str:
    """Makes a vertex group of ``vertices`` (weight 1) and pins it where it is shown.

    Returns:
        The name of the pin. Its ``vertex_group`` may have another one, if such a group was there.
    """
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    indices = groups.checked_indices(obj, vertices)
    pin = new_control(obj, "pin", name, groups.new(obj, indices, name))
    pin.has_made_group = True
    preserve_shape.keep_shown_shape(obj, None, pin)
    return str(pin.name)


def add_pin_group(obj: bpy.types.Object, vertex_group: str) -> str:
    """Pins an existing vertex group where it is shown; the name of the pin.

    If it is pinned already, that pin is chosen and enabled.
    """
    meshes.check_mesh(obj)
    meshes.check_local(obj)
    groups.check(obj, vertex_group)
    settings = obj.arap
    of_group = (i for i, control in enumerate(settings.controls) if control.is_pin)
    former = next((i for i in of_group if settings.controls[i].vertex_group == vertex_group), None)
    if former is None:
        pin = new_control(obj, "pin", vertex_group, vertex_group)
    else:
        pin = settings.controls[former]
        settings.chosen_control_index = former
    if former is None or not pin.is_enabled:
        pin.is_enabled = True
        preserve_shape.keep_shown_shape(obj, None, pin)
    return str(pin.name)
