# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""What is saved of the overlay: ``Object.arap.overlay``. No postponed annotations, as in properties."""

import bpy
from bpy.props import BoolProperty, FloatProperty

from . import hooks


def _on_changed(_settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for changed in hooks.views_changed:
        changed()


class ArapOverlay(bpy.types.PropertyGroup):
    """What is shown of one mesh in the 3D view, while the panel shows that mesh."""

    show_pins: BoolProperty(
        name="Pins", description="Show the pinned vertices in the 3D view", default=False, update=_on_changed
    )
    show_handles: BoolProperty(
        name="Handles",
        description="Show how far each handle has moved: a line from its place at rest",
        default=False,
        update=_on_changed,
    )
    show_strain: BoolProperty(
        name="Strain",
        description="Color the mesh by how much its edges are longer (red) or shorter (blue) than at rest",
        default=False,
        update=_on_changed,
    )
    strain_limit: FloatProperty(
        name="Full Color At",
        description="Strain that gets the full color, in percent of the length at rest",
        default=20.0,
        min=0.1,
        max=1000.0,
        soft_min=1.0,
        soft_max=100.0,
        precision=1,
        subtype="PERCENTAGE",
        update=_on_changed,
    )
