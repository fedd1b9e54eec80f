# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""What a handle that is a cage saves."""

import zlib
from functools import lru_cache

import numpy as np
from bpy.props import BoolProperty, EnumProperty, StringProperty

from ..core.arrays import Floats
from ..core.cages.shape import DOUBLE, CageShape, decoded, encoded

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


@lru_cache(maxsize=8)
def _rest_in(text: str) -> Floats:
    """Kept, as each update asks several times."""
    try:
        positions: Floats = decoded(text, DOUBLE)
    except ValueError:
        positions = np.zeros((0, 3))
    positions.flags.writeable = False
    return positions


class CageRest:
    """A mixin for handles. The shape at rest is saved: the artist edits the cage itself.

    It is saved twice, as the mesh sees it, and as the artist edits it: modifiers and shape keys are between the two.
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
    def cage_rest(self) -> Floats:
        """(c, 3) float64 positions of the cage's vertices at rest, not to be written to; none if they are damaged."""
        return _rest_in(self.cage_text)

    @property
    def cage_shape(self) -> CageShape | None:
        """What the artist edits of the cage, at rest, with the shape keys that shape it there; None if damaged."""
        return CageShape.from_text(self.cage_shape_text)

    def set_cage_rest(self, positions: Floats, shape: CageShape) -> None:
        """See cage_rest and cage_shape."""
        self.cage_text = encoded(positions, DOUBLE)
        self.cage_shape_text = shape.to_text()

    @property
    def cage_rest_id(self) -> int:
        """A number that changes with the shape at rest."""
        return zlib.crc32(self.cage_text.encode())
