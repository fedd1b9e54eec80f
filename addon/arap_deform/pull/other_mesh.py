# SPDX-License-Identifier: GPL-3.0-or-later
"""Another mesh under the mouse, in front of the one in hand: a click takes it in hand."""

from __future__ import annotations

import bpy
from mathutils import Vector

from .seen_mesh import view_of
from .view import Pixels

SEEN_THROUGH = {"BOUNDS", "WIRE"}


def mesh_at(context: bpy.types.Context, pixel: Pixels) -> bpy.types.Object | None:
    """The mesh that is seen at a pixel and may be selected; None if there is none, as on a copy of a collection."""
    origin, direction = view_of(context.region, context.region_data).ray(pixel)
    depsgraph = context.evaluated_depsgraph_get()
    is_hit, _, _, _, found, _ = context.scene.ray_cast(depsgraph, Vector(origin), Vector(direction))
    obj = found.original if is_hit else None
    if obj is None or obj.type != "MESH" or obj.hide_select or obj.display_type in SEEN_THROUGH:
        return None
    space = context.space_data
    is_visible = obj.visible_get(viewport=space if isinstance(space, bpy.types.SpaceView3D) else None)
    return obj if is_visible else None
