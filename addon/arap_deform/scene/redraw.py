# SPDX-License-Identifier: GPL-3.0-or-later
"""Asks Blender to draw again: evaluating the scene alone draws nothing."""

from __future__ import annotations

import bpy

from ..props import hooks


def tag_panels() -> None:
    """The sidebars of all 3D views."""
    _tag_regions("UI")


def tag_meshes() -> None:
    """The scene in all 3D views, without headers and sidebars."""
    _tag_regions("WINDOW")


def tag_views() -> None:
    """All 3D views with their headers and sidebars."""
    for area in _views():
        area.tag_redraw()


def _tag_regions(kind: str) -> None:
    for area in _views():
        for region in area.regions:
            if region.type == kind:
                region.tag_redraw()


def _views() -> list[bpy.types.Area]:
    windows = bpy.context.window_manager.windows
    return [area for window in windows for area in window.screen.areas if area.type == "VIEW_3D"]


CALLBACKS = ((hooks.views_changed, tag_views),)
