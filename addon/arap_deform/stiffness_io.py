# SPDX-License-Identifier: GPL-3.0-or-later
"""The list Stiffness of an object -> what a session is bound with."""

from __future__ import annotations

import bpy

from .stiffness import StiffGroup


def enabled_entries(obj: bpy.types.Object) -> tuple[StiffGroup, ...]:
    """What the list says, without what is switched off."""
    return tuple(
        StiffGroup(entry.name, entry.factor, entry.is_rigid, entry.is_one_body)
        for entry in obj.arap.stiffness
        if entry.is_enabled
    )


def check(obj: bpy.types.Object) -> None:
    """Raises ValueError where an enabled entry has no vertex group."""
    for entry in enabled_entries(obj):
        if entry.group not in obj.vertex_groups:
            raise ValueError(
                f"Stiffness '{entry.group}' of '{obj.name}': there is no vertex group of that name; "
                "choose one or remove it from the list"
            )
