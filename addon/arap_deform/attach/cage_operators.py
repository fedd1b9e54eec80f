# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Make Cage: a coarse mesh around the mesh moves all of it."""

from __future__ import annotations

from typing import Any

import bpy
from bpy.props import IntProperty

from ..pose.job_operator import JobOperator
from ..ui.checks import arap_object, select_alone, why_not_changeable, why_not_object_mode
from .cage import CELLS, CageJob


def why_no_cage_here(context: bpy.types.Context) -> str:
    """As why_not_changeable(). The mesh must be in Object Mode."""
    return why_not_changeable(context) or why_not_object_mode(arap_object(context))


class ARAP_OT_cage_make(JobOperator, bpy.types.Operator):
    bl_idname = "arap.cage_make"
    bl_label = "Make Cage"
    bl_description = (
        "Make a coarse mesh around this one, which moves all of it by a modifier Mesh Deform: pose or edit it as any "
        "mesh"
    )
    bl_options = {"REGISTER", "UNDO"}
    task_name = "Make Cage"
    why_not = staticmethod(why_no_cage_here)

    cells: IntProperty(
        name="Cells",
        description=(
            "Cubes along the longest side of the mesh. More make a cage with more vertices to move: 5 make about 200 "
            "faces, 10 about 650, 20 about 2,200"
        ),
        default=CELLS,
        min=2,
        max=50,
        soft_max=20,
    )

    def begin(self, _context: bpy.types.Context, obj: bpy.types.Object) -> CageJob:
        return CageJob(obj, self.cells)

    def result_text(self, _job: Any, cage: Any) -> str:
        return f"'{cage.name}' has {len(cage.data.vertices)} vertices: Tab edits it, Pull drags it"

    def report_result(self, job: Any, cage: Any) -> None:
        if bpy.context.mode == "OBJECT" and cage.visible_get():
            select_alone(bpy.context, cage)
        super().report_result(job, cage)
