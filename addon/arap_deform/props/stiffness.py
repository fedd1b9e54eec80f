# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""An entry of the list Stiffness, as saved."""

import bpy
from bpy.props import BoolProperty, FloatProperty, StringProperty


def _on_group_changed(entry: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    entry.has_made_group = False  # the new one is the artist's


class ArapStiffness(bpy.types.PropertyGroup):
    """A vertex group that bends less than the rest of the mesh, or not at all."""

    name: StringProperty(
        name="Vertex Group",
        description="Stiffer vertices. Weight 0 is normal, 1 is as stiff as the entry says",
        update=_on_group_changed,
    )
    is_enabled: BoolProperty(
        name="Enabled", description="Stiffen this group. Off: it is as soft as the rest", default=True
    )
    factor: FloatProperty(
        name="Stiffness",
        description=(
            "How many times as stiff as the rest weight 1 is. "
            "Weight is a power: with 100, weight 0.5 is ten times as stiff"
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
            "Vertices of weight 0.5 or more keep their shape exactly, like a helmet. "
            "Each connected piece moves as one piece"
        ),
        default=False,
    )
    is_one_body: BoolProperty(
        name="As One Piece",
        description=(
            "The whole group moves as one piece, even if it is not connected: the shells of a helmet. "
            "Off: each connected piece moves by itself, like two shoes"
        ),
        default=False,
    )
    has_made_group: BoolProperty(
        options={"HIDDEN"}, description="The add-on made the vertex group, and removes it with the entry"
    )
