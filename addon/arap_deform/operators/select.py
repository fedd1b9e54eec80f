# SPDX-License-Identifier: GPL-3.0-or-later
"""Edit Mode of the mesh that the panel means, and the selection of what nothing holds."""

from __future__ import annotations

import bpy
import numpy as np

from .. import unheld
from ..handle_map import Ints
from ..texts import rpt_
from .common import allow, find_posed_object, object_mode, posed_object, reports_errors, why_busy, why_no_mesh


def enter_edit_mode(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Of this mesh alone, whatever is active and selected."""
    if context.object is not None and context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for other in context.selected_objects:
        other.select_set(other == obj)
    obj.select_set(True)
    context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")


class ARAP_OT_edit_mesh(bpy.types.Operator):
    bl_idname = "arap.edit_mesh"
    bl_label = "ARAP Edit Mode"
    bl_description = "Go to Edit Mode of the mesh, where vertices are selected, or back to Object Mode"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, _why_not_editable(context))

    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        if obj.mode == "EDIT":
            bpy.ops.object.mode_set(mode="OBJECT")
        else:
            enter_edit_mode(context, obj)
        return {"FINISHED"}


class ARAP_OT_select_unheld(bpy.types.Operator):
    bl_idname = "arap.select_unheld"
    bl_label = "Select ARAP Parts without Pins and Handles"
    bl_description = "Select, in Edit Mode, the parts of the mesh that no pin or handle holds, and its loose vertices"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        reason = _why_not_editable(context)
        obj = find_posed_object(context)
        if not reason and obj is not None and not (obj.arap.pins or obj.arap.handles):
            reason = "Add a pin or a handle first: nothing holds the mesh yet"
        return allow(cls, reason)

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        with object_mode(obj):
            vertices, n_parts = unheld.find(obj, context.evaluated_depsgraph_get())
        if not len(vertices):
            self.report({"INFO"}, rpt_("Every part of the mesh is held by a pin or handle"))
            return {"FINISHED"}
        if obj.mode == "EDIT":
            bpy.ops.object.mode_set(mode="OBJECT")
        select_vertices(obj, vertices)
        context.tool_settings.mesh_select_mode = (True, False, False)
        enter_edit_mode(context, obj)
        self.report({"INFO"}, rpt_("Selected {} vertices, in {} parts of the mesh").format(len(vertices), n_parts))
        return {"FINISHED"}


def select_vertices(obj: bpy.types.Object, vertices: Ints) -> None:
    """These alone, shown where they were hidden. Not in Edit Mode."""
    mesh = obj.data
    is_selected = np.zeros(len(mesh.vertices), dtype=bool)
    is_selected[vertices] = True
    is_hidden = np.empty(len(mesh.vertices), dtype=bool)
    mesh.vertices.foreach_get("hide", is_hidden)
    mesh.vertices.foreach_set("hide", is_hidden & ~is_selected)
    mesh.vertices.foreach_set("select", is_selected)
    # In vertex mode Blender selects edges and faces by their vertices when it enters Edit Mode; what is left from
    # before would stay.
    for items in (mesh.edges, mesh.polygons):
        items.foreach_set("select", np.zeros(len(items), dtype=bool))
    mesh.update()


def _why_not_editable(context: bpy.types.Context) -> str:
    """As why_no_mesh(), and no act must have the mesh."""
    obj = find_posed_object(context)
    return why_no_mesh(context) or ("" if obj is None else why_busy(obj))


CLASSES = (ARAP_OT_edit_mesh, ARAP_OT_select_unheld)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
