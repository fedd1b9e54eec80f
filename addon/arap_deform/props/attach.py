# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Attachments as saved: a list on the host; on an attached object, what was made for that."""

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


def _on_changed(attachment: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for changed in hooks.attachment_changed:
        changed(attachment.id_data, attachment)


class ArapAttachment(bpy.types.PropertyGroup):
    """An object that is attached to the mesh that has it in its list."""

    object: PointerProperty(type=bpy.types.Object, name="Object", description="The object that is attached")
    is_enabled: BoolProperty(
        name="Enabled", description="The object follows the mesh. Off: it is at rest", default=True, update=_on_changed
    )
    kind: EnumProperty(
        name="Kind", description="How the object follows the mesh", items=KINDS, default="bend", update=_on_changed
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


class ArapLinkedKey(bpy.types.PropertyGroup):
    """A shape key of an attached object that stands for one of its host."""

    name: StringProperty(name="Name", description="Name of the host's shape key")
    key: StringProperty(name="Key", description="Name of the attached object's shape key")


class ArapAttachedTo(bpy.types.PropertyGroup):
    """What an attached object knows of its host."""

    host: PointerProperty(
        type=bpy.types.Object, name="Host", description="The mesh that this object follows", options={"HIDDEN"}
    )
    linked_keys: CollectionProperty(
        type=ArapLinkedKey,
        name="Linked Keys",
        description="Shape keys that stand for those of the host",
        options={"HIDDEN"},
    )
    has_made_reference: BoolProperty(
        options={"HIDDEN"}, description="The object had no shape keys before it was attached"
    )
