# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Make Cage and Add Cage: a closed mesh around the mesh moves all of it."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import IntProperty

from ..pose.job_operator import JobOperator
from ..setup.handles import following_first_handle
from ..setup.rows import take_in_hand
from ..ui.checks import ArapOperator, posed_object, why_not_changeable, why_not_object_mode
from .make import CELLS, CageJob, add_cage


def selected_cages(context: bpy.types.Context, obj: bpy.types.Object) -> list[bpy.types.Object]:
    """The selected meshes but ``obj``."""
    return [other for other in context.selected_objects if other.type == "MESH" and other != obj]


def why_no_cage_here(context: bpy.types.Context) -> str:
    """As why_not_changeable(). The mesh must be in Object Mode."""
    return why_not_changeable(context) or why_not_object_mode(posed_object(context))


def why_no_selected_cage(context: bpy.types.Context) -> str:
    """As why_no_cage_here(). One other mesh must be selected, too."""
    reason = why_no_cage_here(context)
    if reason or len(selected_cages(context, posed_object(context))) == 1:
        return reason
    return "Click a closed mesh around the mesh, then Shift-click the mesh itself"


class FollowedCageJob(CageJob):
    """The cage of an artist: the mesh follows it."""

    def finish(self) -> Any:
        with following_first_handle(self.find_object()):
            return super().finish()


class ARAP_OT_cage_make(JobOperator, bpy.types.Operator):
    bl_idname = "arap.cage_make"
    bl_label = "Make Cage"
    bl_description = (
        "Make a coarse mesh around this one, which moves all of it: edit its vertices, its shape keys, or move it"
    )
    bl_options = {"REGISTER", "UNDO"}
    act_name = "Make Cage"
    why_not = staticmethod(why_no_cage_here)

    cells: IntProperty(
        name="Cells",
        description=(
            "Cubes along the longest side of the mesh. More make a cage with more vertices to move, and slower: 5 make "
            "about 200 faces, 10 about 650, 20 about 2,200. Each frame takes time with the faces times the vertices of "
            "the mesh: for 100,000 vertices about 4, 15 and 40 ms"
        ),
        default=CELLS,
        min=2,
        max=50,
        soft_max=20,
    )

    def begin(self, _context: bpy.types.Context, obj: bpy.types.Object) -> CageJob:
        return FollowedCageJob(obj, self.cells)

    def result_text(self, _job: Any, handle: Any) -> str:
        return f"'{handle.target.name}' has {len(handle.target.data.vertices)} vertices: Tab edits it"

    def report_result(self, job: Any, handle: Any) -> None:
        if bpy.context.mode == "OBJECT":
            take_in_hand(bpy.context, handle)
        super().report_result(job, handle)


class ARAP_OT_cage_add(ArapOperator, bpy.types.Operator):
    bl_idname = "arap.cage_add"
    bl_label = "Add Cage"
    bl_description = (
        "The other selected mesh, a closed one around this one, moves all of it. "
        "Again: its present shape becomes its rest"
    )
    why_not = staticmethod(why_no_selected_cage)
    ends_itself = True

    def act(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        cages = selected_cages(context, obj)
        if len(cages) != 1:
            raise ValueError("Select the cage and the mesh, and no other mesh")
        with following_first_handle(obj):
            handle = add_cage(obj, cages[0])
        if context.mode == "OBJECT":
            take_in_hand(context, handle)
