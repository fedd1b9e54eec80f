# SPDX-License-Identifier: GPL-3.0-or-later
"""The sub-panel "First Pose": five lines that are buttons, and are ticked off, until the mesh has been posed."""

from __future__ import annotations

import bpy

from ..ui.checks import find_posed_object
from ..ui.panels import ArapPanel, draw_text
from . import first_pose


class ARAP_PT_first_pose(ArapPanel, bpy.types.Panel):
    """What somebody new does next."""

    bl_idname = "ARAP_PT_first_pose"
    bl_label = "First Pose"
    bl_parent_id = "ARAP_PT_main"
    bl_order = 0

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return first_pose.is_wanted(find_posed_object(context))

    def draw(self, context: bpy.types.Context) -> None:
        steps = first_pose.steps(find_posed_object(context))
        following = next(step for step in steps if not step.is_done)
        column = self.layout.column()
        for number, step in enumerate(steps, 1):
            row = column.row()
            row.active = step is following
            row.label(text="", icon="CHECKBOX_HLT" if step.is_done else "CHECKBOX_DEHLT")
            text = f"{number}. {step.text}"
            if step.is_done or not step.operator:
                row.label(text=text, translate=False)
            else:
                button = row.operator(step.operator, text=text, translate=False)
                if step.mode:
                    button.mode = step.mode
            if step is following:
                problem = first_pose.why_not(context, step)
                draw_text(context, column, problem or step.hint, "ERROR" if problem else "BLANK1")


def register() -> None:
    bpy.utils.register_class(ARAP_PT_first_pose)


def unregister() -> None:
    bpy.utils.unregister_class(ARAP_PT_first_pose)
