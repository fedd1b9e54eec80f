# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""What a handle that is a cage saves."""

import zlib

import bpy
from bpy.props import BoolProperty, EnumProperty, StringProperty

# Files store the numbers, so an item keeps its number.
COORDINATES = (
    (
        "mean_value",
        "Mean Value",
        "The mesh follows the cage closely. It need not be inside of it. Fast",
        "NONE",
        0,
    ),
    (
        "harmonic",
        "Harmonic",
        "A limb follows its own part of the cage alone, and never goes the other way. All of the mesh must be inside",
        "NONE",
        1,
    ),
    (
        "green",
        "Green",
        "Keeps the shapes of details, but follows the cage less closely. All of the mesh must be inside",
        "NONE",
        2,
    ),
)


def may_be_cage(obj: bpy.types.Object) -> bool:
    """Whether a look that takes no time finds no reason against it, for a list of objects; see scene/cages."""
    return obj.type == "MESH" and len(obj.data.polygons) > 0


class CageRest:
    """A mixin for handles. The shape at rest is saved: the artist edits the cage itself.

    It is saved twice, as the mesh sees it, and as the artist edits it: modifiers and shape keys are between the two.
    Both are read in scene/cages: some Blenders never let go of a class with properties, and of what its module holds.
    """

    is_cage: BoolProperty(options={"HIDDEN"}, description="Its object is a cage, which moves the whole mesh")
    coordinates: EnumProperty(
        name="Coordinates",
        description="How the mesh hangs on its cage",
        items=COORDINATES,
        default="mean_value",
    )
    cage_text: StringProperty(
        options={"HIDDEN"},
        description="Positions of the cage's vertices at rest, in the space of the mesh (float64), base64",
    )

    cage_shape_text: StringProperty(
        options={"HIDDEN"}, description="What the artist edits of the cage, at rest; see CageShape in core/cages"
    )

    @property
    def cage_rest_id(self) -> int:
        """A number that changes with the shape at rest."""
        return zlib.crc32(self.cage_text.encode())
