# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects that the add-on knows, by their ``session_uid``, and what an evaluation has changed of them.

A uid survives an undo, a new name and a swap of names; loading a file gives new ones. Known are the objects with data
of the add-on's, and those of which a room remembers something. When the scene changes, nobody looks at the others.
"""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from dataclasses import dataclass

import bpy

_keys: dict[int, tuple[str, str | None]] = {}
"""Name and library of each known object when it was seen last, by its uid: what Blender finds it by."""
_n_objects = 0  # in the file, at the last look


@dataclass(frozen=True)
class Update:
    """A known object that an evaluation has changed.

    Attributes:
        evaluated: the object as evaluated.
        is_moved: its matrix has changed.
        is_deformed: its geometry has changed, by modifiers at least.
        has_new_data: the mesh or curve itself has changed.
    """

    uid: int
    obj: bpy.types.Object
    evaluated: bpy.types.Object
    is_moved: bool
    is_deformed: bool
    has_new_data: bool


def add(obj: bpy.types.Object) -> int:
    """Makes the object a known one. Returns its uid."""
    uid = int(obj.session_uid)
    _keys[uid] = _key_of(obj)
    return uid


def _key_of(obj: bpy.types.Object) -> tuple[str, str | None]:
    return obj.name, obj.library.filepath if obj.library is not None else None


def find(uid: int) -> bpy.types.Object | None:
    """The object, None if it is gone."""
    obj = bpy.data.objects.get(_keys.get(uid, ("", None)))
    if obj is None or obj.session_uid != uid:
        obj = next((other for other in bpy.data.objects if other.session_uid == uid), None)
        if obj is not None and uid in _keys:
            _keys[uid] = _key_of(obj)
    return obj


def find_in(place: bpy.types.Scene | bpy.types.ViewLayer, uid: int) -> bpy.types.Object | None:
    """The object, if a scene or view layer has it: quick for a known one, as it is asked at each redraw."""
    obj = place.objects.get(_keys.get(uid, ("", None))[0])
    if obj is None or obj.session_uid != uid:
        obj = find(uid)
    return obj if is_in(place, obj) else None


def find_scene(uid: int) -> bpy.types.Scene | None:
    """The scene, None if it is gone."""
    return next((scene for scene in bpy.data.scenes if scene.session_uid == uid), None)


def any_objects() -> bool:
    return bool(_keys)


def is_known(uid: int) -> bool:
    return uid in _keys


def all_objects() -> list[bpy.types.Object]:
    """The known objects of the file."""
    return [obj for obj in bpy.data.objects if obj.session_uid in _keys] if _keys else []


def is_in(place: bpy.types.Scene | bpy.types.ViewLayer, obj: bpy.types.Object | None) -> bool:
    """Whether a scene or view layer has the object."""
    found = place.objects.get(obj.name) if obj is not None else None
    if found is None or found == obj:
        return found is not None
    return any(other == obj for other in place.objects)  # a linked object has the same name


def updates(depsgraph: bpy.types.Depsgraph) -> list[Update]:
    """What was changed of known objects."""
    changed, data = [], set()
    for update in depsgraph.updates:
        original = update.id.original
        uid = original.session_uid
        if uid in _keys:
            changed.append((original, update.id, update.is_updated_transform, update.is_updated_geometry))
        elif update.is_updated_geometry:
            data.add(uid)
    return [
        Update(obj.session_uid, obj, evaluated, is_moved, is_deformed, _uid_of_data(obj) in data)
        for obj, evaluated, is_moved, is_deformed in changed
    ]


def _uid_of_data(obj: bpy.types.Object) -> int:
    return 0 if obj.data is None else int(obj.data.session_uid)


def may_be_others(depsgraph: bpy.types.Depsgraph) -> bool:
    """Whether an evaluation may be of other objects than the one before."""
    is_other_scene = depsgraph.id_type_updated("SCENE") or depsgraph.id_type_updated("COLLECTION")
    return is_other_scene or are_more_or_fewer()


def are_more_or_fewer() -> bool:
    """Whether the file has another number of objects than at the last look."""
    return len(bpy.data.objects) != _n_objects


def look_again() -> AbstractSet[int]:
    """Finds the objects with data of the add-on's: a file was loaded, objects were appended, or undo brought them.

    Forgets the known objects that the file has no more. Returns their uids.
    """
    global _n_objects  # noqa: PLW0603 - compared by handlers
    there = set()
    for obj in bpy.data.objects:
        there.add(obj.session_uid)
        # Blender makes the settings when they are first read: of most objects there are none.
        if obj.is_property_set("arap") and obj.arap.has_data():
            add(obj)
    _n_objects = len(there)
    gone = _keys.keys() - there
    for uid in gone:
        del _keys[uid]
    return gone


def clear() -> None:
    global _n_objects  # noqa: PLW0603 - as above
    _n_objects = 0
    _keys.clear()
