# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Paint, select or soften the vertex group of a pin, a handle or an entry of Stiffness.

Without a name they take the mesh's active vertex group: choosing an entry in a list makes its group the active one.
"""

import bpy
import numpy as np
from bpy.props import FloatProperty, StringProperty

from ..core.arrays import Ints
from ..scene import groups, meshes, ui_cache
from ..ui.checks import ArapOperator, arap_object, check_visible, why_busy, why_not_changeable
from ..ui.edit_mode import object_mode
from .select_operators import select_in_edit_mode
from .stiffness import soften_group

DEFAULT_RADIUS = 0.05  # of a soft edge, as a fraction of the mesh's size


def why_no_group(context: bpy.types.Context) -> str:
    """As why_not_changeable(). The mesh must have a vertex group."""
    lack = "There is no vertex group yet: add a pin, a handle or stiffness first"
    return why_not_changeable(context) or ("" if arap_object(context).vertex_groups else lack)


def why_not_selectable(context: bpy.types.Context) -> str:
    """As why_no_group(). No task, posing neither, may be using the mesh."""
    return why_no_group(context) or why_busy(arap_object(context))


def is_painted(obj: bpy.types.Object, vertex_group: str) -> bool:
    """Whether Weight Paint is on and paints this group."""
    active = obj.vertex_groups.active
    return obj.mode == "WEIGHT_PAINT" and active is not None and active.name == vertex_group


class _GroupOperator(ArapOperator):
    """What the operators share."""

    why_not = staticmethod(why_no_group)

    vertex_group: StringProperty(
        name="Vertex Group", description="Name of the group. Empty: the active group", options={"SKIP_SAVE"}
    )

    def group_of(self, obj: bpy.types.Object) -> str:
        """The name of the group. Raises ValueError if the mesh does not have it."""
        active = obj.vertex_groups.active
        name = self.vertex_group or ("" if active is None else str(active.name))
        groups.check(obj, name)
        return name


class ARAP_OT_group_paint(_GroupOperator, bpy.types.Operator):
    bl_idname = "arap.group_paint"
    bl_label = "Paint Weights"
    bl_description = (
        "Paint the weights of this vertex group in Weight Paint Mode; again: back to Object Mode. "
        "A mesh that follows its handles follows each stroke"
    )

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        group = self.group_of(obj)
        mode = "OBJECT" if is_painted(obj, group) else "WEIGHT_PAINT"
        obj.vertex_groups.active_index = obj.vertex_groups.find(group)
        check_visible(obj)
        context.view_layer.objects.active = obj
        obj.select_set(True)
        bpy.ops.object.mode_set(mode=mode)


class ARAP_OT_group_select(_GroupOperator, bpy.types.Operator):
    bl_idname = "arap.group_select"
    bl_label = "Select Vertices"
    bl_description = "Select only the vertices of this group with a weight above 0, in Edit Mode"
    why_not = staticmethod(why_not_selectable)

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        group = self.group_of(obj)

        def find() -> Ints:
            return np.flatnonzero(meshes.read_weights(obj, [group])[group]).astype(np.int32)

        if not select_in_edit_mode(context, obj, find, shows_hidden=False):
            raise ValueError(f"No vertex has weight in '{group}': paint some, or assign vertices to it")


class ARAP_OT_group_soften(_GroupOperator, bpy.types.Operator):
    bl_idname = "arap.group_soften"
    bl_label = "Soften Edge"
    bl_description = (
        "Fade the weights of this vertex group out around its vertices of weight 1, along the surface at rest. "
        "Weights below 1 are replaced"
    )

    radius: FloatProperty(
        name="Radius",
        description=(
            "Distance from the vertices of weight 1 to weight 0, in scene units. 0: a hard edge. "
            "The first value is a twentieth of the mesh's size"
        ),
        default=0.1,
        min=0.0,
        soft_max=10.0,
        subtype="DISTANCE",
        options={"SKIP_SAVE"},
    )

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        group = self.group_of(obj)
        if not self.properties.is_property_set("radius"):
            self.radius = DEFAULT_RADIUS * ui_cache.diagonal(obj, context.evaluated_depsgraph_get())
        with object_mode(obj):
            soften_group(obj, group, self.radius)
