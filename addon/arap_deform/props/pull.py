# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""The temporary pins of ARAP Pull, saved, and how the tool takes hold. No postponed annotations, as in properties."""

import base64

import bpy
import numpy as np
from bpy.props import FloatProperty, IntProperty, StringProperty
from numpy.typing import NDArray


class ArapPullPin(bpy.types.PropertyGroup):
    """A piece of surface that stays where it is shown for as long as the tool ARAP Pull is on."""

    vertices_text: StringProperty(options={"HIDDEN"}, description="Its vertices: int32, base64")
    reach: FloatProperty(
        options={"HIDDEN"}, description="How far the mesh was free around it when it was pulled; 0: set by a click"
    )

    n_vertices: IntProperty(
        options={"HIDDEN"}, description="Vertices that the mesh had: with another number its own are others"
    )

    @property
    def vertices(self) -> NDArray[np.int32]:
        """(k,) ascending."""
        return np.frombuffer(base64.b64decode(self.vertices_text), dtype="<i4").astype(np.int32)

    @vertices.setter
    def vertices(self, vertices: NDArray[np.int32]) -> None:
        self.vertices_text = base64.b64encode(vertices.astype("<i4").tobytes()).decode()


class ArapPullSettings(bpy.types.PropertyGroup):
    """How the tool ARAP Pull takes hold: of the window, so that undo leaves it alone."""

    radius: IntProperty(
        name="Radius",
        description="Radius of the piece that is pulled, in pixels of the view (F, [ and ]; the wheel during a drag)",
        default=40,
        min=1,
        max=10000,
        soft_max=500,
        subtype="PIXEL",
    )
    falloff: FloatProperty(
        name="Falloff",
        description="How far the mesh gives way while there is no pin, in radii beyond the piece that is pulled",
        default=3.0,
        min=0.1,
        max=1000.0,
        soft_max=20.0,
        precision=1,
    )
