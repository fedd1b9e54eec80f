# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""What goes along with a mesh, as saved: a list of followers on the mesh; on a follower, what was made for that."""

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatVectorProperty,
    PointerProperty,
    StringProperty,
)
from mathutils import Matrix

from ..core.transforms import IDENTITY
from . import hooks

# Files store the numbers, so an item keeps its number.
KINDS = (
    ("bend", "Bend", "It bends with the surface near it, as clothes, belts and hair cards do", "NONE", 0),
    (
        "rigid",
        "Rigid",
        "It keeps its shape, as eyes, teeth and buttons do. Each loose piece of it moves by itself",
        "NONE",
        1,
    ),
)


def _on_changed(follower: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for changed in hooks.follower_changed:
        changed(follower.id_data, follower)


class ArapFollower(bpy.types.PropertyGroup):
    """An object that goes along with the mesh that has it in its list."""

    target: PointerProperty(type=bpy.types.Object, name="Object", description="The object that goes along")
    is_enabled: BoolProperty(
        name="Enabled", description="The object goes along. Off: it is at rest", default=True, update=_on_changed
    )
    kind: EnumProperty(
        name="Kind", description="How the object goes along", items=KINDS, default="bend", update=_on_changed
    )
    place: FloatVectorProperty(
        name="Place",
        description="Matrix of the object in the space of the mesh when it was added; 4x4, row by row",
        size=16,
        default=IDENTITY,
        options={"HIDDEN"},
    )

    def set_place(self, matrix: Matrix) -> None:
        self.place = [value for row in matrix for value in row]


class ArapTwin(bpy.types.PropertyGroup):
    """A shape key of a follower that stands for one of its mesh."""

    name: StringProperty(name="Name", description="Name of the shape key of the mesh that it goes along with")
    key: StringProperty(name="Key", description="Name of the follower's own shape key")


class ArapCarried(bpy.types.PropertyGroup):
    """What a follower knows of the mesh that it goes along with."""

    body: PointerProperty(
        type=bpy.types.Object,
        name="Goes Along With",
        description="The mesh that this object goes along with",
        options={"HIDDEN"},
    )
    twins: CollectionProperty(
        type=ArapTwin, name="Twins", description="Shape keys that were made for that", options={"HIDDEN"}
    )
    has_made_reference: BoolProperty(
        options={"HIDDEN"}, description="The object had no shape keys before it went along"
    )
