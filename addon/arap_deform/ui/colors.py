# SPDX-License-Identifier: GPL-3.0-or-later
"""The colours of what is drawn in the 3D view: those of the user's theme, or of the preferences."""

from __future__ import annotations

from typing import Any

import bpy

from ..props import preferences

Color = tuple[float, float, float, float]


def of_pins() -> Color:
    """In the theme: as bones in Pose Mode."""
    return _opaque(preferences.color("pin_color") or _theme().view_3d.bone_pose)


def of_handles() -> Color:
    """In the theme: as selected vertices."""
    return _opaque(preferences.color("handle_color") or _theme().view_3d.vertex_select)


def of_pull() -> Color:
    """In the theme: as the gizmos."""
    return _opaque(preferences.color("pull_color") or _theme().user_interface.gizmo_primary)


def _theme() -> bpy.types.Theme:
    return bpy.context.preferences.themes[0]


def _opaque(color: Any) -> Color:
    return (color[0], color[1], color[2], 1.0)
