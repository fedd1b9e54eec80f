# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""An entry of the list of pins, handles and bones, and one of the list Stiffness, as saved."""

import secrets

import bpy
from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from mathutils import Matrix

from ..core.transforms import IDENTITY
from . import hooks
from .base_shape import BaseShape

KINDS = (
    ("pin", "Pin", "A vertex group that stays where it was when it was added"),
    ("handle", "Handle", "A vertex group that follows an object, or a bone of an armature"),
    ("bone", "Bone", "A bone that moves what it passes through inside the mesh, without a vertex group"),
)


def _may_be_target(control: bpy.types.PropertyGroup, candidate: bpy.types.Object) -> bool:
    return bool(candidate != control.id_data)


def _on_changed(control: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for changed in hooks.control_changed:
        changed(control.id_data, control)


def _on_renamed(control: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for renamed in hooks.control_renamed:
        renamed(control.id_data, control)


def _on_target_changed(control: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    control.has_made_target = False  # the new one is the artist's
    _on_changed(control, context)


def _on_group_changed(control: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    control.has_made_group = False  # as above
    _on_changed(control, context)


def _on_own_group_changed(entry: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    entry.has_made_group = False  # as above


class ArapControl(BaseShape, bpy.types.PropertyGroup):
    """A pin, a handle or a bone: what holds or moves a part of the mesh."""

    kind: EnumProperty(
        name="Kind", description="What it does with the mesh", items=KINDS, default="handle", update=_on_changed
    )
    name: StringProperty(
        name="Name",
        description="Its name, and that of the empty and the vertex group that were made for it",
        update=_on_renamed,
    )
    is_enabled: BoolProperty(name="Enabled", description="Off: what it holds or moves is free", default=True)
    vertex_group: StringProperty(
        name="Vertex Group",
        description="Vertices that stay, or follow. Weight 1 holds exactly, less pulls, 0 is free",
        update=_on_group_changed,
    )
    target: PointerProperty(
        type=bpy.types.Object,
        name="Object",
        description="The object that moves the group: an empty, any other object, or an armature with a bone",
        poll=_may_be_target,
        update=_on_target_changed,
    )
    bone: StringProperty(name="Bone", description="Bone of the armature that moves the group", update=_on_changed)
    use_exact: BoolProperty(
        name="Exact",
        description=(
            "Hold every vertex, also if the handle is smaller than Rigidity. "
            "Off: a small handle holds the average of a round patch, which pulls a smooth hill and no spike"
        ),
    )
    rest_matrix: FloatVectorProperty(
        name="Rest Matrix",
        description="Matrix of the object in the space of the mesh, with the mesh at rest; 4x4, row by row",
        size=16,
        default=IDENTITY,
        options={"HIDDEN"},
    )
    has_made_group: BoolProperty(
        options={"HIDDEN"}, description="The add-on made the vertex group, and removes it with the entry"
    )
    has_made_target: BoolProperty(
        options={"HIDDEN"}, description="The add-on made the empty, and removes it with the handle"
    )
    group_radius: FloatProperty(
        min=0.0,
        options={"HIDDEN"},
        description="Radius of the group when the add-on made it, in world units; 0: it did not",
    )
    reach: FloatProperty(
        min=0.0,
        options={"HIDDEN"},
        description="How far a point handle reaches until it is reset, in rigidity radii; 0: up to other handles",
    )
    pose_id: IntProperty(options={"HIDDEN"}, description="Its number; 0: nobody has asked for it yet")

    @property
    def number(self) -> int:
        """By which it is known, whatever its name; made when it is first asked for."""
        if not self.pose_id:
            self.pose_id = 1 + secrets.randbelow(2**31 - 2)
        return int(self.pose_id)

    @property
    def is_pin(self) -> bool:
        """Whether it stays where it is; else an object or a bone moves it."""
        return bool(self.kind == "pin")

    @property
    def label(self) -> str:
        """Its kind and its name, for messages."""
        return f"{self.kind.capitalize() or 'Handle'} '{self.name}'"

    def forget_base(self) -> None:
        super().forget_base()
        self.reach = 0.0

    @property
    def rest(self) -> Matrix:
        """O_rest^-1 M_rest as a 4x4 Matrix."""
        values = self.rest_matrix
        return Matrix((values[0:4], values[4:8], values[8:12], values[12:16]))

    @rest.setter
    def rest(self, matrix: Matrix) -> None:
        self.rest_matrix = [value for row in matrix for value in row]


class ArapStiffness(bpy.types.PropertyGroup):
    """A vertex group that bends less than the rest of the mesh, or not at all."""

    name: StringProperty(
        name="Vertex Group",
        description="Stiffer vertices. Weight 0 is normal, 1 is as stiff as the entry says",
        update=_on_own_group_changed,
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
    use_rigid: BoolProperty(
        name="Rigid",
        description=(
            "Vertices of weight 0.5 or more keep their shape exactly, like a helmet. "
            "Each connected piece moves as one piece"
        ),
    )
    use_single_body: BoolProperty(
        name="As One Piece",
        description=(
            "The whole group moves as one piece, even if it is not connected: the shells of a helmet. "
            "Off: each connected piece moves by itself, like two shoes"
        ),
    )
    has_made_group: BoolProperty(
        options={"HIDDEN"}, description="The add-on made the vertex group, and removes it with the entry"
    )
