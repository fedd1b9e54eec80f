# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of files that are older than what has taken their place."""

from __future__ import annotations

import bpy

from . import compat, shape_key

FORMER_KEY_NAME = "key_name"  # as it was saved; today it is ``own_key_name``, and key_name is made of that
FORMER_DEFAULT_KEY_NAME = "ARAP"  # which was not saved


def is_outdated(obj: bpy.types.Object) -> bool:
    """Whether upgrade() has something to do: not for a linked object, which shows what was saved."""
    if obj.library is not None:
        return False
    saved = compat.saved_settings(obj)
    if saved is None:
        return False
    has_key_name = FORMER_KEY_NAME in saved or _shows_unsaved_name(obj)
    return has_key_name or bool(obj.arap.rigid_group or obj.arap.stiffness_group)


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
        # The original one: a mesh as evaluated need not have its shape keys.
        if isinstance(update.id, bpy.types.Object) and is_outdated(update.id.original):
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
    elif _shows_unsaved_name(obj):
        obj.arap.own_key_name = FORMER_DEFAULT_KEY_NAME


def _shows_unsaved_name(obj: bpy.types.Object) -> bool:
    """Whether a pose or a bake is in keys of the former default name. Today both save their name."""
    settings = obj.arap
    if settings.is_property_set("own_key_name") or obj.type != "MESH":
        return False
    if FORMER_DEFAULT_KEY_NAME in settings.made_keys and shape_key.find(obj, FORMER_DEFAULT_KEY_NAME) is not None:
        return True
    return any(shape_key.frame_keys(obj, f"{FORMER_DEFAULT_KEY_NAME}_"))
