# SPDX-License-Identifier: GPL-3.0-or-later
"""Which mesh an object goes along with."""

from __future__ import annotations

import bpy

from .problems import above, is_in_scene, pair_with


def body_of(obj: bpy.types.Object) -> bpy.types.Object | None:
    """The mesh that an object goes along with; None if there is none, it is deleted, or its list says: switched off."""
    body, follower = pair_with(obj) or (None, None)
    return body if follower is not None and follower.is_enabled and is_in_scene(body) else None


def moving_mesh(obj: bpy.types.Object) -> bpy.types.Object:
    """What moves the object if it is pulled: the mesh that it goes along with, or the one with which that does.

    And so on; a circle ends. Itself if it goes along with none.
    """
    return [obj, *above(obj, body_of)][-1]
