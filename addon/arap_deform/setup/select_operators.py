# SPDX-License-Identifier: GPL-3.0-or-later
"""Enter and leave Edit Mode of the panel's mesh, and select vertices there."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..core.arrays import Ints
from ..scene import meshes
from ..ui.checks import ArapOperator, arap_object, check_visible, select_alone, why_busy, why_no_mesh
from ..ui.edit_mode import object_mode
from . import free_parts


def enter_edit_mode(context: bpy.types.Context, obj: bpy.types.Object) -> None:
    """For this mesh alone. Raises ValueError if it is hidden."""
    _take_alone(context, obj)
    bpy.ops.object.mode_set(mode="EDIT")


def select_in_edit_mode(
    context: bpy.types.Context, obj: bpy.types.Object, find: Callable[[], Ints], *, shows_hidden: bool
) -> int:
    """Selects only the vertices that ``find`` returns, in Edit Mode of this mesh alone. Does nothing if it finds none.

    Leaves Edit Mode once, for both reading the mesh and selecting: entering it takes long on a large mesh.

    Returns:
        The number of vertices found.

    Raises:
        ValueError: the mesh is hidden.
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
    """Makes it active and the only selected object, in Object Mode. Raises ValueError if it is hidden."""
    check_visible(obj)
    if context.object is not None and context.object.mode != "OBJECT":
        bpy.ops.object.mode_set(mode="OBJECT")
    select_alone(context, obj)


def why_not_editable(context: bpy.types.Context) -> str:
    """As why_no_mesh(). No task may be using the mesh."""
    return why_no_mesh(context) or why_busy(arap_object(context))


def why_nothing_held(context: bpy.types.Context) -> str:
    """As why_not_editable(). The mesh must have a pin or a handle."""
    lack = "Add a pin or a handle first: nothing holds the mesh yet"
    return why_not_editable(context) or ("" if arap_object(context).arap.controls else lack)


class ARAP_OT_edit_mesh(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.edit_mesh"
    bl_label = "Edit Mode"
    bl_description = "Go to Edit Mode of the mesh to select vertices, or back to Object Mode"
    why_not = staticmethod(why_not_editable)

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        if obj.mode == "EDIT":
            bpy.ops.object.mode_set(mode="OBJECT")
        else:
            enter_edit_mode(context, obj)


class ARAP_OT_select_free_parts(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.select_free_parts"
    bl_label = "Select Free Parts"
    bl_description = (
        "Select the parts of the mesh and the loose vertices that stay at rest, in Edit Mode: they have no pin or "
        "handle, and follow none"
    )
    why_not = staticmethod(why_nothing_held)

    def modify(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        n_parts = 0

        def find() -> Ints:
            nonlocal n_parts
            vertices, n_parts = free_parts.find(obj, context.evaluated_depsgraph_get())
            return vertices

        n = select_in_edit_mode(context, obj, find, shows_hidden=True)
        message = (
            f"Selected {n} vertices in {n_parts} parts"
            if n
            else "Every part of the mesh has a pin or handle, or follows one that has"
        )
        self.report({"INFO"}, message)
