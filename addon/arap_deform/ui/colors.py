# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of the user's theme for what is drawn in the 3D view."""

from __future__ import annotations

from typing import Any

import bpy

Color = tuple[float, float, float, float]


def of_pins() -> Color:
    """As bones in Pose Mode."""
    return _opaque(_theme().view_3d.bone_pose)


def of_handles() -> Color:
    """As selected vertices."""
    return _opaque(_theme().view_3d.vertex_select)


def of_pull() -> Color:
    """As gizmos."""
    return _opaque(_theme().user_interface.gizmo_primary)


def _theme() -> bpy.types.Theme:
    return bpy.context.preferences.themes[0]


def _opaque(color: Any) -> Color:
    return (color[0], color[1], color[2], 1.0)
