# SPDX-License-Identifier: GPL-3.0-or-later
"""Which mesh the tool pulls: the one in hand, or another one under the mouse, which a click takes in hand."""

from __future__ import annotations

import bpy
from mathutils import Vector

from ..attach.hosts import moving_mesh
from ..ui.checks import arap_object, hidden_text
from .evaluated_mesh import view_of
from .view import Pixels

SEEN_THROUGH = {"BOUNDS", "WIRE"}


def pulled_object(context: bpy.types.Context) -> bpy.types.Object:
    """The mesh in hand, or what moves that. Raises ValueError if there is none."""
    return moving_mesh(arap_object(context))


def mesh_at(context: bpy.types.Context, pixel: Pixels) -> bpy.types.Object | None:
    """The mesh that is seen at a pixel and may be selected, or what moves that.

    None if there is none, as on a copy of a collection. Raises ValueError if what moves it is hidden.
    """
    origin, direction = view_of(context.region, context.region_data).ray(pixel)
    depsgraph = context.evaluated_depsgraph_get()
    is_hit, _, _, _, found, _ = context.scene.ray_cast(depsgraph, Vector(origin), Vector(direction))
    obj = found.original if is_hit else None
    if obj is None or (moving := moving_mesh(obj)).type != "MESH":
        return None
    # A stand-in is not seen, but its meshes are, at the same place.
    if not obj.arap.is_stand_in and (obj.hide_select or obj.display_type in SEEN_THROUGH):
        return None
    space = context.space_data
    view = space if isinstance(space, bpy.types.SpaceView3D) else None
    if moving.visible_get(viewport=view):
        return moving
    if moving != obj and obj.visible_get(viewport=view):
        raise ValueError(hidden_text(moving))
    return None
