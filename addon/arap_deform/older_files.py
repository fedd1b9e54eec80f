# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of files that are older than what has taken their place."""

from __future__ import annotations

import bpy

from . import compat

FORMER_KEY_NAME = "key_name"  # as it was saved; today it is ``own_key_name``, and key_name is made of that


def is_outdated(obj: bpy.types.Object) -> bool:
    """Whether upgrade() has something to do: not for a linked object, which shows what was saved."""
    if obj.library is not None:
        return False
    saved = compat.saved_settings(obj)
    return bool(obj.arap.rigid_group or obj.arap.stiffness_group) or (saved is not None and FORMER_KEY_NAME in saved)


def upgrade(obj: bpy.types.Object) -> None:
    """Takes over what has another place by now."""
    _upgrade_stiffness(obj)
    _upgrade_key_name(obj)


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


def _upgrade_stiffness(obj: bpy.types.Object) -> None:
    """Makes entries of the two settings that there were before the list, which meant just that."""
    settings = obj.arap
    for name, is_rigid in ((settings.rigid_group, True), (settings.stiffness_group, False)):
        if name:
            entry = settings.stiffness.add()
            entry.name, entry.is_rigid = name, is_rigid
    settings.property_unset("rigid_group")
    settings.property_unset("stiffness_group")


def _upgrade_key_name(obj: bpy.types.Object) -> None:
    """Else the pose would go to another key and add to the one that the file shows."""
    saved = compat.saved_settings(obj)
    if saved is not None and FORMER_KEY_NAME in saved:
        obj.arap.own_key_name = obj.arap.own_key_name or saved[FORMER_KEY_NAME]
        del saved[FORMER_KEY_NAME]
