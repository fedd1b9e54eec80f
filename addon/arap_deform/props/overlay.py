# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""Settings of the overlay: ``Object.arap.overlay``."""

import bpy
from bpy.props import BoolProperty, FloatProperty

from . import hooks


def _on_changed(_settings: bpy.types.PropertyGroup, _context: bpy.types.Context) -> None:
    for changed in hooks.views_changed:
        changed()


class ArapOverlay(bpy.types.PropertyGroup):
    """What is drawn over one mesh, while the panel shows that mesh."""

    show_pins: BoolProperty(name="Pins", description="Draw the pinned vertices", default=False, update=_on_changed)
    show_handles: BoolProperty(
        name="Handles",
        description="Draw a line from each handle's rest place to its place now",
        default=False,
        update=_on_changed,
    )
    show_strain: BoolProperty(
        name="Stretch",
        description="Color the mesh by the length of its edges: red is longer than at rest, blue is shorter",
        default=False,
        update=_on_changed,
    )
    strain_limit: FloatProperty(
        name="Full Color At",
        description="Stretch of the full color, in percent of the length at rest",
        default=20.0,
        min=0.1,
        max=1000.0,
        soft_min=1.0,
        soft_max=100.0,
        precision=1,
        subtype="PERCENTAGE",
        update=_on_changed,
    )
