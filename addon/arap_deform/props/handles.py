# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""What is saved of a pin and of a handle. No postponed annotations, as in properties."""

import bpy
from bpy.props import (
    BoolProperty,
    FloatProperty,
    FloatVectorProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from mathutils import Matrix

from ..core.transforms import IDENTITY
from . import hooks


def _is_other_object(settings: bpy.types.PropertyGroup, candidate: bpy.types.Object) -> bool:
    return bool(candidate != settings.id_data)


def _on_handle_changed(handle: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for changed in hooks.handle_changed:
        changed(handle.id_data, handle)


def _on_target_changed(handle: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    handle.has_made_target = False  # another one, which is the artist's
    _on_handle_changed(handle, context)


def _on_group_changed(handle: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    handle.has_made_group = False  # as above
    _on_handle_changed(handle, context)


def _on_pin_group_changed(pin: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    pin.has_made_group = False  # as above


class ArapPin(bpy.types.PropertyGroup):
    """A vertex group that stays where it is at rest."""

    name: StringProperty(
        name="Vertex Group",
        description="Vertices held at rest: 1 holds, less pulls, 0 is free",
        update=_on_pin_group_changed,
    )
    is_enabled: BoolProperty(name="Enabled", description="Hold this group. Off: its vertices are free", default=True)
    has_made_group: BoolProperty(options={"HIDDEN"}, description="The vertex group goes when the pin is removed")


class ArapHandle(bpy.types.PropertyGroup):
    """A vertex group that follows an object or a bone."""

    name: StringProperty(name="Name", description="Name of the handle")
    is_enabled: BoolProperty(
        name="Enabled", description="Let the group follow. Off: its vertices are free", default=True
    )
    target: PointerProperty(
        type=bpy.types.Object,
        name="Object",
        description="The object that moves the group: an empty, or an armature together with a bone",
        poll=_is_other_object,
        update=_on_target_changed,
    )
    bone: StringProperty(
        name="Bone", description="Bone of the armature that moves the group", update=_on_handle_changed
    )
    vertex_group: StringProperty(
        name="Vertex Group",
        description="Vertices that follow: 1 follows exactly, less pulls, 0 is free",
        update=_on_group_changed,
    )
    is_exact: BoolProperty(
        name="Exact",
        description=(
            "Hold every vertex of a handle that is smaller than Rigidity. "
            "Off: it holds the average of a round patch about them, which pulls a smooth hill and no spike"
        ),
        default=False,
    )
    rest_matrix: FloatVectorProperty(
        name="Rest Matrix",
        description="Where the object stands in the mesh's own space while the mesh is at rest; 4x4, row by row",
        size=16,
        default=IDENTITY,
        options={"HIDDEN"},
    )
    has_made_group: BoolProperty(options={"HIDDEN"}, description="The vertex group goes when the handle is removed")
    has_made_target: BoolProperty(options={"HIDDEN"}, description="The empty goes when the handle is removed")
    group_radius: FloatProperty(
        options={"HIDDEN"},
        description="Size of the group when the handle was made, in world units; 0: not made here",
    )

    pose_id: IntProperty(options={"HIDDEN"}, description="Number by which stored poses know the handle; 0: none does")

    @property
    def rest(self) -> Matrix:
        """O_rest^-1 M_rest as a 4x4 Matrix."""
        values = self.rest_matrix
        return Matrix((values[0:4], values[4:8], values[8:12], values[12:16]))

    @rest.setter
    def rest(self, matrix: Matrix) -> None:
        self.rest_matrix = [value for row in matrix for value in row]
