# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""The temporary pins of the tool ARAP Pull, as saved, and the settings of the tool."""

import base64

import bpy
import numpy as np
from bpy.props import BoolProperty, FloatProperty, IntProperty, StringProperty
from numpy.typing import NDArray

from .base_shape import BaseShape


class ArapPullPin(bpy.types.PropertyGroup):
    """A piece of the surface that stays in its place while the tool ARAP Pull is on."""

    vertices_text: StringProperty(options={"HIDDEN"}, description="Its vertices: int32, base64")
    reach: FloatProperty(
        min=0.0,
        options={"HIDDEN"},
        description="Radius of the free mesh around the piece when it was pulled; 0: pinned by a click",
    )
    root: FloatProperty(
        min=0.0,
        options={"HIDDEN"},
        description="Distance along the surface to the root of the limb that was pulled; 0: the reach counts",
    )
    n_vertices: IntProperty(
        options={"HIDDEN"}, description="Number of vertices of the mesh: with another one the piece is invalid"
    )

    @property
    def vertices(self) -> NDArray[np.int32]:
        """(k,) ascending; none if what is saved is damaged."""
        try:
            saved = np.frombuffer(base64.b64decode(self.vertices_text), dtype="<i4").astype(np.int32)
        except ValueError:
            return np.zeros(0, np.int32)
        is_sound = np.all(saved[:-1] < saved[1:]) and np.all((saved >= 0) & (saved < self.n_vertices))
        return saved if is_sound else np.zeros(0, np.int32)

    @vertices.setter
    def vertices(self, vertices: NDArray[np.int32]) -> None:
        self.vertices_text = base64.b64encode(vertices.astype("<i4").tobytes()).decode()


class ArapPullRest(BaseShape, bpy.types.PropertyGroup):
    """The rest of the mesh as the last drag held it."""


def _on_changed(_settings: bpy.types.PropertyGroup, context: bpy.types.Context) -> None:
    context.preferences.is_dirty = True  # so that Blender saves them when it ends


class ArapPullSettings(bpy.types.PropertyGroup):
    """Settings of the tool ARAP Pull. The preferences keep them: for every file, and undo does not change them."""

    radius: IntProperty(
        name="Radius",
        description="Radius of the pulled piece, in pixels (F, [ and ]; the wheel during a drag)",
        default=40,
        min=1,
        max=10000,
        soft_max=500,
        subtype="PIXEL",
        update=_on_changed,
    )
    use_auto_reach: BoolProperty(
        name="Auto Reach",
        description=(
            "While there is no pin, the limb under the mouse gives way, up to its root: an arm, a leg, a tail, an ear, "
            "a head. What is no limb gives way as far as Reach"
        ),
        default=True,
        update=_on_changed,
    )
    use_turn: BoolProperty(
        name="Turn Along",
        description="The pulled piece of a limb turns as the limb swings about its joint. Off: it keeps its angle",
        default=True,
        update=_on_changed,
    )
    reach: FloatProperty(
        name="Reach",
        description="How far the mesh gives way around the pulled piece while there is no pin, in radii",
        default=3.0,
        min=0.1,
        max=1000.0,
        soft_max=20.0,
        precision=1,
        update=_on_changed,
    )
