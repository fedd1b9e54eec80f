# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""What is saved of the pose library: ``Object.arap.poses``. No postponed annotations, as in properties."""

import bpy
from bpy.props import CollectionProperty, FloatVectorProperty, IntProperty, StringProperty

from ..core.transforms import IDENTITY
from . import hooks


def _on_renamed(pose: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for renamed in hooks.pose_renamed:
        renamed(pose.id_data, pose)


class ArapStoredMotion(bpy.types.PropertyGroup):
    """What one handle has done in a stored pose."""

    name: StringProperty(name="Handle", description="Name of the handle when the pose was stored")
    handle_id: IntProperty(options={"HIDDEN"}, description="Which handle it is, however it is named by now")
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
        type=ArapStoredMotion, name="Motions", description="What each handle has done", options={"HIDDEN"}
    )
    key_name: StringProperty(options={"HIDDEN"}, description="Shape key that was made of the pose")
    key_check: StringProperty(
        options={"HIDDEN"}, description="Checksum of that key's shape: a key that somebody has changed since is his"
    )


CLASSES = (ArapStoredMotion, ArapStoredPose)
