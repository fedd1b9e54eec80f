# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""The pose library, as saved: ``Object.arap.poses``."""

import bpy
from bpy.props import CollectionProperty, FloatVectorProperty, IntProperty, StringProperty

from ..core.transforms import IDENTITY
from . import hooks


def _on_renamed(pose: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for renamed in hooks.pose_renamed:
        renamed(pose.id_data, pose)


class ArapStoredMotion(bpy.types.PropertyGroup):
    """The motion of one handle in a stored pose."""

    name: StringProperty(name="Handle", description="Name of the handle when the pose was stored")
    handle_id: IntProperty(options={"HIDDEN"}, description="Number of the handle, which may have another name now")
    motion: FloatVectorProperty(
        name="Motion",
        description="Motion of the handle since rest, in the mesh's own space; 4x4, row by row",
        size=16,
        default=IDENTITY,
        options={"HIDDEN"},
    )


class ArapStoredPose(bpy.types.PropertyGroup):
    """A pose of the handles."""

    name: StringProperty(name="Name", description="Name of the pose", maxlen=63, update=_on_renamed)
    motions: CollectionProperty(
        type=ArapStoredMotion, name="Motions", description="The motion of each handle", options={"HIDDEN"}
    )
    key_name: StringProperty(options={"HIDDEN"}, description="Shape key made from the pose")
    key_check: StringProperty(
        options={"HIDDEN"}, description="Checksum of that key's shape: a key with another one was changed by the user"
    )
