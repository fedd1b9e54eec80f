# SPDX-License-Identifier: GPL-3.0-or-later
"""What later rooms do when something happens here: each appends a function when it registers, and removes it after.

So props knows nobody, and a later room needs no import here to be told.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy

control_changed: list[Callable[[bpy.types.Object, Any], None]] = []
"""A control has another object, bone or vertex group: the object and the ArapControl."""

control_renamed: list[Callable[[bpy.types.Object, Any], None]] = []
"""A control has another name: the object and the ArapControl."""

control_chosen: list[Callable[[bpy.types.Object, Any], None]] = []
"""A row of the list of controls was clicked: the object and the ArapControl."""

display_changed: list[Callable[[bpy.types.Object], None]] = []
"""The empties of the handles must look different."""

follow_toggled: list[Callable[[bpy.types.Object], None]] = []
"""Follow was switched on or off."""

pose_renamed: list[Callable[[bpy.types.Object, Any], None]] = []
"""A stored pose has another name: the object and the ArapStoredPose."""

views_changed: list[Callable[[], None]] = []
"""The 3D views must be drawn again."""

key_written: list[Callable[[bpy.types.Object, bpy.types.ShapeKey, Any, bool], None]] = []
"""A shape key of the add-on's has other coordinates: the mesh object, the key, and (n, 3) float32 of them, which are
valid during the call. The last is whether it is a frame of a motion: then others may follow a little later."""

keys_changed: list[Callable[[bpy.types.Object], None]] = []
"""Shape keys of the add-on's have come or gone, or have other names or keyframes."""

rest_changes: list[Callable[[bpy.types.Object, bpy.types.ShapeKey], None]] = []
"""What the pose's key shows will be the rest shape of the mesh: the object and the key, as they are before. May raise
ValueError, before it changes anything; then nothing changes."""

attachment_changed: list[Callable[[bpy.types.Object, Any], None]] = []
"""An attachment was switched on or off, or has another kind: the host and the ArapAttachment."""
