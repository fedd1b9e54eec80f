# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""What is saved of an entry of the list Stiffness. No postponed annotations, as in properties."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty


def _on_group_changed(entry: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    entry.has_made_group = False  # another one, which is the artist's


class ArapStiffness(bpy.types.PropertyGroup):
    """A vertex group that bends less than the rest of the mesh, or not at all."""

    name: StringProperty(
        name="Vertex Group",
        description="Vertices that are stiffer: 0 is normal, 1 as stiff as this entry says",
        update=_on_group_changed,
    )
    is_enabled: BoolProperty(name="Enabled", description="Stiffen this group. Off: it is as the rest", default=True)
    factor: FloatProperty(
        name="Stiffness",
        description=(
            "How many times as stiff as the rest the mesh is at weight 1. "
            "Each step of weight multiplies: with 100, weight 0.5 is ten times as stiff"
        ),
        default=100.0,
        min=1.0,
        max=100.0,
        precision=1,
        step=100,
    )
    is_rigid: BoolProperty(
        name="Rigid",
        description=(
            "Keep the shape of the vertices with weight 0.5 or more exactly, as a helmet or a shoe does: "
            "each connected piece moves as one body"
        ),
        default=False,
    )
    is_one_body: BoolProperty(
        name="One Body",
        description=(
            "All of the group moves as one body, also pieces that are not joined: a helmet of several shells. "
            "Off: each piece is a body of its own, as two shoes are"
        ),
        default=False,
    )
    has_made_group: BoolProperty(options={"HIDDEN"}, description="The vertex group goes when the entry is removed")
