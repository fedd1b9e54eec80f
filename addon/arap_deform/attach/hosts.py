# SPDX-License-Identifier: GPL-3.0-or-later
"""The host that an object is attached to."""

from __future__ import annotations

import bpy

from .problems import above, is_in_scene, pair_with


def host_of(obj: bpy.types.Object) -> bpy.types.Object | None:
    """The host of an object; None if it has none, if that is deleted, or if the attachment is switched off."""
    host, attachment = pair_with(obj) or (None, None)
    return host if attachment is not None and attachment.is_enabled and is_in_scene(host) else None


def moving_mesh(obj: bpy.types.Object) -> bpy.types.Object:
    """What moves the object if it is pulled: its host, or the host of that, and so on; itself if it has none."""
    return [obj, *above(obj, host_of)][-1]
