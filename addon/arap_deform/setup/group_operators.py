# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""What is done with the vertex group of a pin, a handle or an entry of Stiffness: paint, select, soften.

The group is the one that a list has chosen, or the active one of the mesh, which is the same: a list makes the group of
what is chosen in it the active one.
"""

import bpy
import numpy as np
from bpy.props import FloatProperty, StringProperty

from ..core.arrays import Ints
from ..scene import groups, mesh_size, meshes
from ..ui.checks import allow, check_visible, object_mode, posed_object, reports_errors, why_busy, why_not_changeable
from .select_operators import select_in_edit_mode
from .stiffness import soften_group

DEFAULT_RADIUS = 0.05  # of a soft edge, as a fraction of the mesh's size


def why_no_group(context: bpy.types.Context) -> str:
    """As why_not_changeable(), and there must be a vertex group."""
    reason = why_not_changeable(context)
    if reason or posed_object(context).vertex_groups:
        return reason
    return "There is no vertex group yet: add a pin, a handle or stiffness first"


def is_painted(obj: bpy.types.Object, vertex_group: str) -> bool:
    """Whether Weight Paint is on, and paints this group."""
    active = obj.vertex_groups.active
    return obj.mode == "WEIGHT_PAINT" and active is not None and active.name == vertex_group


class _GroupOperator:
    """What the operators share."""

    vertex_group: StringProperty(
        name="Vertex Group", description="Which one; none: the active one", options={"SKIP_SAVE"}
    )

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_group(context))

    def _group(self, obj: bpy.types.Object) -> str:
        """The group that is meant. Raises ValueError where it is not there."""
        active = obj.vertex_groups.active
        name = self.vertex_group or ("" if active is None else str(active.name))
        groups.check(obj, name)
        return name


class ARAP_OT_group_paint(_GroupOperator, bpy.types.Operator):
    bl_idname = "arap.group_paint"
    bl_label = "Paint ARAP Weights"
    bl_description = (
        "Paint the weights of this vertex group in Weight Paint Mode; again: back to Object Mode. "
        "Live and posing follow each stroke"
    )
    bl_options = {"REGISTER", "UNDO"}

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        group = self._group(obj)
        mode = "OBJECT" if is_painted(obj, group) else "WEIGHT_PAINT"
        obj.vertex_groups.active_index = obj.vertex_groups.find(group)
        check_visible(obj)
        context.view_layer.objects.active = obj
        obj.select_set(True)
        bpy.ops.object.mode_set(mode=mode)
        return {"FINISHED"}


class ARAP_OT_group_select(_GroupOperator, bpy.types.Operator):
    bl_idname = "arap.group_select"
    bl_label = "Select ARAP Vertices"
    bl_description = "Select the vertices of this group that have weight, and nothing else, in Edit Mode"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_no_group(context) or why_busy(posed_object(context)))

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        group = self._group(obj)

        def find() -> Ints:
            return np.flatnonzero(meshes.read_weights(obj, [group])[group]).astype(np.int32)

        if not select_in_edit_mode(context, obj, find, shows_hidden=False):
            raise ValueError(f"No vertex has weight in '{group}': paint some, or assign vertices to it")
        return {"FINISHED"}


class ARAP_OT_group_soften(_GroupOperator, bpy.types.Operator):
    bl_idname = "arap.group_soften"
    bl_label = "Soften ARAP Edge"
    bl_description = (
        "Fade the weights of this vertex group out around its vertices of weight 1, along the surface at rest. "
        "Weights below 1 are replaced"
    )
    bl_options = {"REGISTER", "UNDO"}

    radius: FloatProperty(
        name="Radius",
        description=(
            "How far from the vertices of weight 1 the weights reach 0, in scene units. 0: a hard edge. "
            "At first a twentieth of the mesh's size"
        ),
        default=0.1,
        min=0.0,
        soft_max=10.0,
        subtype="DISTANCE",
        options={"SKIP_SAVE"},
    )

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        group = self._group(obj)
        if not self.properties.is_property_set("radius"):
            self.radius = DEFAULT_RADIUS * mesh_size.diagonal(obj, context.evaluated_depsgraph_get())
        with object_mode(obj):
            soften_group(obj, group, self.radius)
        return {"FINISHED"}


CLASSES = (ARAP_OT_group_paint, ARAP_OT_group_select, ARAP_OT_group_soften)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
