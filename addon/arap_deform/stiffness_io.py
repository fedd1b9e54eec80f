# SPDX-License-Identifier: GPL-3.0-or-later
"""The list Stiffness of an object -> what a session is bound with; and settings of older files -> the list."""

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


def upgrade(obj: bpy.types.Object) -> None:
    """Makes entries of the two settings that files had before there was the list, which meant just that."""
    settings = obj.arap
    for name, is_rigid in ((settings.rigid_group, True), (settings.stiffness_group, False)):
        if name:
            entry = settings.stiffness.add()
            entry.name, entry.is_rigid = name, is_rigid
    settings.property_unset("rigid_group")
    settings.property_unset("stiffness_group")


def upgrade_all() -> None:
    """upgrade() of everything in this file."""
    for obj in bpy.data.objects:
        if is_outdated(obj):
            upgrade(obj)


def upgrade_updated(depsgraph: bpy.types.Depsgraph) -> None:
    """After an evaluation: upgrade() of what was appended from an older file, or set so by an older script."""
    for update in depsgraph.updates:
        if isinstance(update.id, bpy.types.Object) and is_outdated(update.id):
            upgrade(update.id.original)


def is_outdated(obj: bpy.types.Object) -> bool:
    """Whether upgrade() has something to do: not for a linked object, which shows what was saved."""
    settings = obj.arap
    return obj.library is None and bool(settings.rigid_group or settings.stiffness_group)
