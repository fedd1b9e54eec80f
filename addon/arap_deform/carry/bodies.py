# SPDX-License-Identifier: GPL-3.0-or-later
"""Which mesh an object goes along with."""

from __future__ import annotations

import bpy

from .problems import entry_of, is_in_scene


def body_of(obj: bpy.types.Object) -> bpy.types.Object | None:
    """The mesh that an object goes along with; None if there is none, it is deleted, or its list says: switched off."""
    body = obj.arap.carried.body
    entry = entry_of(body, obj) if body is not None else None
    return body if entry is not None and entry.is_enabled and is_in_scene(body) else None


def moving_mesh(obj: bpy.types.Object) -> bpy.types.Object:
    """What moves the object if it is pulled: the mesh that it goes along with, or the one with which that does.

    And so on; a circle ends. Itself if it goes along with none.
    """
    passed = [obj]
    while (body := body_of(passed[-1])) is not None and body not in passed:
        passed.append(body)
    return passed[-1]
