# SPDX-License-Identifier: GPL-3.0-or-later
# mypy: disable-error-code="valid-type"
"""The add-on's preferences: settings of the user and the machine, not of a file."""

from typing import Any

import bpy
from bpy.props import FloatProperty, IntProperty, PointerProperty, StringProperty

from ..core.tracker import REFINE_TIME_LIMIT_S
from .pull import ArapPullSettings

ADDON = (__package__ or "").rpartition(".")[0]  # as Blender knows the add-on: in an extension, bl_ext.REPOSITORY.NAME
KEY_NAME = "ARAP"


class ArapPreferences(bpy.types.AddonPreferences):
    """Edit > Preferences > Add-ons > ARAP Deform."""

    bl_idname = ADDON

    threads: IntProperty(
        name="Threads",
        description="CPU threads. 0 is automatic",
        min=0,
        max=1024,
        soft_max=64,
    )
    refine_time: FloatProperty(
        name="Refine Time",
        description=(
            "How long one step of settling may block Blender, in seconds. Longer settles sooner, "
            "shorter keeps the mouse smoother"
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
        description="Name of the shape key that takes the pose, for meshes without a name of their own",
        default=KEY_NAME,
        maxlen=63,
    )
    pull: PointerProperty(type=ArapPullSettings, name="ARAP Pull", description="Settings of the tool ARAP Pull")

    def draw(self, _context: bpy.types.Context) -> None:
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.prop(self, "key_name")
        column.prop(self, "threads")
        column.prop(self, "refine_time")


def threads() -> int:
    return int(_value("threads", 0))


def refine_time_s() -> float:
    return float(_value("refine_time", REFINE_TIME_LIMIT_S))


def key_name() -> str:
    """Never empty."""
    return str(_value("key_name", "")) or KEY_NAME


def pull() -> ArapPullSettings:
    """The settings of the tool ARAP Pull. Only of an add-on that is enabled."""
    return bpy.context.preferences.addons[ADDON].preferences.pull  # type: ignore[no-any-return]


def _value(name: str, default: Any) -> Any:
    # A script may register the add-on without enabling it: then it has no preferences.
    addon = bpy.context.preferences.addons.get(ADDON)
    return getattr(addon.preferences, name, default) if addon is not None else default
