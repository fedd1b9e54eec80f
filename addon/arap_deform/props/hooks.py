# SPDX-License-Identifier: GPL-3.0-or-later
"""What later rooms do when something happens here: each appends a function when it registers, and removes it after.

So props knows nobody, and a later room needs no import here to be told.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import bpy

handle_changed: list[Callable[[bpy.types.Object, Any], None]] = []
"""A handle has another object, bone or vertex group: the object and the ArapHandle."""

handle_renamed: list[Callable[[bpy.types.Object, Any], None]] = []
"""A handle has another name: the object and the ArapHandle."""

row_chosen: list[Callable[[bpy.types.Object, int], None]] = []
"""A row of the list of handles and pins was clicked: the object and its number."""

display_changed: list[Callable[[bpy.types.Object], None]] = []
"""The empties of the handles must look different."""

live_toggled: list[Callable[[bpy.types.Object], None]] = []
"""Live was switched on or off."""

pose_renamed: list[Callable[[bpy.types.Object, Any], None]] = []
"""A stored pose has another name: the object and the ArapStoredPose."""

views_changed: list[Callable[[], None]] = []
"""The 3D views must be drawn again."""

posed: list[Callable[[bpy.types.Object], None]] = []
"""A frame of posing, Live or Pull, or a solve, has written the pose's shape key. Not called for a pose taken back."""
