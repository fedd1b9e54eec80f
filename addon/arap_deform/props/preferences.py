# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""The add-on's preferences: what belongs to the user and the machine, not to a file.

No ``from __future__ import annotations`` here: Blender reads the annotations themselves, not their text.
"""

from typing import Any

import bpy
from bpy.props import BoolProperty, FloatProperty, FloatVectorProperty, IntProperty, StringProperty

from ..core.following import REFINE_TIME_LIMIT_S
from . import hooks

ADDON = (__package__ or "").rpartition(".")[0]  # as Blender knows the add-on: in an extension, bl_ext.REPOSITORY.NAME
KEY_NAME = "ARAP"
COLORS = ("pin_color", "handle_color", "pull_color")


def _on_color_changed(_preferences: bpy.types.AddonPreferences, _context: bpy.types.Context) -> None:
    for changed in hooks.views_changed:
        changed()


def _color(name: str, description: str, default: tuple[float, float, float]) -> Any:
    return FloatVectorProperty(
        name=name,
        description=description,
        subtype="COLOR_GAMMA",  # drawn as they are, like those of a theme
        default=default,
        min=0.0,
        max=1.0,
        update=_on_color_changed,
    )


class ArapPreferences(bpy.types.AddonPreferences):
    """Edit > Preferences > Add-ons > ARAP Deform."""

    bl_idname = ADDON

    threads: IntProperty(
        name="Threads",
        description="Processor threads to use; 0 takes as many as pay at the size of the mesh",
        default=0,
        min=0,
        max=1024,
        soft_max=64,
    )
    refine_time: FloatProperty(
        name="Refine Time",
        description=(
            "How long a step of settling may keep Blender waiting, in seconds. Longer settles sooner, shorter keeps "
            "the mouse smoother while it does"
        ),
        default=REFINE_TIME_LIMIT_S,
        min=0.005,
        max=2.0,
        soft_max=0.5,
        step=1,
        precision=3,
        subtype="TIME_ABSOLUTE",
        unit="TIME_ABSOLUTE",
    )
    key_name: StringProperty(
        name="Shape Key",
        description="Name of the shape key that takes the pose, for meshes that have none of their own set",
        default=KEY_NAME,
        maxlen=63,
    )
    use_theme_colors: BoolProperty(
        name="Theme Colors",
        description="Draw pins, ways of the handles and what ARAP Pull shows in colors of your theme",
        default=True,
        update=_on_color_changed,
    )
    pin_color: _color("Pins", "Color of the pinned vertices", (0.25, 0.6, 1.0))
    handle_color: _color("Handles", "Color of the ways of the handles from rest", (1.0, 0.55, 0.1))
    pull_color: _color("Patch", "Color of the circle, the patch and the dots of ARAP Pull", (1.0, 0.9, 0.2))

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.prop(self, "key_name")
        column.prop(self, "threads")
        column.prop(self, "refine_time")
        column = layout.column(heading="Colors")
        column.prop(self, "use_theme_colors", text="From the Theme")
        colors = column.column()
        colors.active = not self.use_theme_colors
        for name in COLORS:
            colors.prop(self, name)


def threads() -> int:
    return int(_value("threads", 0))


def refine_time_s() -> float:
    return float(_value("refine_time", REFINE_TIME_LIMIT_S))


def key_name() -> str:
    """Never empty."""
    return str(_value("key_name", "")) or KEY_NAME


def color(name: str) -> tuple[float, float, float] | None:
    """One of COLORS; None where the theme's is to be taken."""
    if _value("use_theme_colors", True):
        return None
    red, green, blue = _value(name, (1.0, 1.0, 1.0))
    return (red, green, blue)


def _value(name: str, default: Any) -> Any:
    # A script may have registered the add-on without enabling it: then there are none.
    addon = bpy.context.preferences.addons.get(ADDON)
    return getattr(addon.preferences, name, default) if addon is not None else default


def register() -> None:
    bpy.utils.register_class(ArapPreferences)


def unregister() -> None:
    bpy.utils.unregister_class(ArapPreferences)
