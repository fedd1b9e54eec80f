# SPDX-License-Identifier: GPL-3.0-or-later
"""Edit Mode of the mesh that the panel means, and the selection of what nothing holds."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..core.arrays import Ints
from ..scene import meshes, unheld
from ..ui.checks import allow, check_visible, object_mode, posed_object, reports_errors, why_busy, why_no_mesh


def enter_edit_mode(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Of this mesh alone, whatever is active and selected. Raises ValueError where it is hidden."""
    _take_alone(context, obj)
    bpy.ops.object.mode_set(mode="EDIT")


def select_in_edit_mode(
    context: bpy.types.Context, obj: bpy.types.Object, find: Callable[[], Ints], *, shows_hidden: bool
) -> int:
    """Selects the vertices found, and nothing else, in Edit Mode of this mesh alone; where none are, nothing happens.

    Edit Mode is left once at most, because entering it takes long on a large mesh: while ``find`` reads the mesh and
    Blender is told what is selected.

    Returns:
        How many were found.

    Raises:
        ValueError: where the mesh is hidden.
    """
    check_visible(obj)
    with object_mode(obj):
        vertices = find()
        if not len(vertices):
            return 0
        _take_alone(context, obj)
        meshes.select_vertices(obj, vertices, shows_hidden=shows_hidden)
        context.tool_settings.mesh_select_mode = (True, False, False)
    if obj.mode != "EDIT":
        bpy.ops.object.mode_set(mode="EDIT")
    return len(vertices)


def _take_alone(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """Makes it the only object that is selected, and active, in Object Mode. Raises ValueError where it is hidden."""
    check_visible(obj)
    if context.object is not None and context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    for other in context.selected_objects:
        other.select_set(other == obj)
    obj.select_set(True)
    context.view_layer.objects.active = obj


class ARAP_OT_edit_mesh(bpy.types.Operator):
    bl_idname = "arap.edit_mesh"
    bl_label = "ARAP Edit Mode"
    bl_description = "Go to Edit Mode of the mesh, where vertices are selected, or back to Object Mode"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return allow(cls, why_not_editable(context))

    @reports_errors
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
        reason = why_not_editable(context)
        if not reason and not (posed_object(context).arap.pins or posed_object(context).arap.handles):
            reason = "Add a pin or a handle first: nothing holds the mesh yet"
        return allow(cls, reason)

    @reports_errors
    def execute(self, context: bpy.types.Context) -> set[str]:
        obj = posed_object(context)
        n_parts = 0

        def find() -> Ints:
            nonlocal n_parts
            vertices, n_parts = unheld.find(obj, context.evaluated_depsgraph_get())
            return vertices

        n = select_in_edit_mode(context, obj, find, shows_hidden=True)
        if n:
            self.report({"INFO"}, f"Selected {n} vertices, in {n_parts} parts of the mesh")
        else:
            self.report({"INFO"}, "Every part of the mesh is held by a pin or handle")
        return {"FINISHED"}


def why_not_editable(context: bpy.types.Context) -> str:
    """As why_no_mesh(), and no act must have the mesh."""
    return why_no_mesh(context) or why_busy(posed_object(context))


CLASSES = (ARAP_OT_edit_mesh, ARAP_OT_select_unheld)


def register() -> None:
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister() -> None:
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
