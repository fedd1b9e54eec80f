# SPDX-License-Identifier: GPL-3.0-or-later
"""The pose key: the shape key that takes the pose of an object. Which one it is, what it shows, what Esc brings back.

The add-on has made it (``made_keys``), and it has the name in ``obj.arap``. If a key of the artist's own has that name,
it is left alone, and the pose key takes the next free name, as Blender numbers names.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy
import numpy as np

from ..core import sessions
from ..core.arrays import Float32s
from ..core.session_input import key_differs
from ..props import preferences
from . import shape_keys, versions


@dataclass(frozen=True)
class KeyState:
    """What restore() brings back. No Blender data.

    Attributes:
        name: of the pose key, or the one it would have had.
        setting: the name in ``obj.arap``, '' for that of the preferences.
        has_keys: whether the mesh had any shape key, Basis included.
        positions: (n, 3) float32 of the key, None if there was none.
        active: the key chosen in the list, '' if there was none.
    """

    name: str
    setting: str
    has_keys: bool
    positions: Float32s | None = None
    value: float = 0.0
    slider_max: float = 1.0
    active: str = ""


def wanted_name(obj: bpy.types.Object) -> str:
    """The name that is set for the pose key: the object's own, or that of the preferences."""
    return str(obj.arap.key_name) or preferences.key_name()


def check_name(obj: bpy.types.Object) -> None:
    """Raises ValueError if the name in ``obj.arap`` cannot be the pose key's."""
    name = wanted_name(obj)
    keys = obj.data.shape_keys
    if keys is not None and keys.reference_key.name == name:
        raise ValueError(f"Shape key '{name}' of '{obj.name}' is its rest shape: choose another name for the pose")


@dataclass(frozen=True)
class PoseKey:
    """The pose key, None if there is none yet, and its name or the one it will have."""

    name: str
    key: bpy.types.ShapeKey | None


def look(obj: bpy.types.Object) -> PoseKey:
    """Finds the pose key. Its name is the wanted one, numbered if a key of the artist's own has that."""
    settings, keys = obj.arap, obj.data.shape_keys
    name = settings.key_name or preferences.key_name()
    key = keys.key_blocks.get(name) if keys is not None else None
    if key is None or name in settings.made_keys:
        return PoseKey(name, key)
    return PoseKey(shape_keys.free_name(obj, name), None)


def find(obj: bpy.types.Object) -> bpy.types.ShapeKey | None:
    """The pose key, None if there is none yet."""
    return look(obj).key


def shown(obj: bpy.types.Object) -> bpy.types.ShapeKey | None:
    """The pose key if it shows something."""
    key = find(obj)
    return None if key is None or key.mute or key.value == 0.0 else key


def shown_positions(obj: bpy.types.Object, rest: Float32s) -> Float32s:
    """(n, 3) float32 the pose shown by the pose key, without other keys and modifiers."""
    key = shown(obj)
    if key is not None and key.value == 1.0:
        return versions.read_key(key)  # to the last bit
    return rest if key is None else np.asarray(rest + key.value * (versions.read_key(key) - rest), dtype=np.float32)


def name_of(obj: bpy.types.Object) -> str:
    """The pose key's name, or the one it will have."""
    return look(obj).name


def ensure(obj: bpy.types.Object) -> bpy.types.ShapeKey:
    """The pose key, made at rest (value 0) if there is none, with Basis if the mesh has no keys."""
    found = look(obj)
    return found.key or _make(obj, found.name)


def writable(obj: bpy.types.Object, found: PoseKey | None = None) -> bpy.types.ShapeKey:
    """As ensure(). Raises ValueError if the key would not show what is written to it.

    ``found``: from look(), if that was called before.
    """
    found = found or look(obj)
    check_name(obj)
    shape_keys.check_writable(obj)
    key = found.key or _make(obj, found.name)
    shape_keys.check_shown(obj, key)
    return key


def _make(obj: bpy.types.Object, name: str) -> bpy.types.ShapeKey:
    key = shape_keys.add(obj, name)
    _mark(obj, key.name)
    shape_keys.notify_keys_changed(obj)
    return key


def forget_removed(obj: bpy.types.Object) -> None:
    """Forgets keys that were removed or renamed in Blender's list: another key of that name is not the add-on's."""
    made = obj.arap.made_keys
    for index in reversed(range(len(made))):
        if shape_keys.find(obj, made[index].name) is None:
            made.remove(index)


def capture(obj: bpy.types.Object) -> KeyState:
    """The state of the pose key."""
    key = find(obj)
    keys = obj.data.shape_keys
    state = KeyState(name_of(obj), obj.arap.key_name, keys is not None, active=shape_keys.active_name(obj))
    if key is None:
        return state
    return replace(state, positions=versions.read_key(key), value=key.value, slider_max=key.slider_max)


def restore(obj: bpy.types.Object, state: KeyState) -> None:
    """Back to ``state``. Keys that were not there are removed.

    Raises:
        ValueError: the mesh has another number of vertices now; nothing is written.
    """
    if state.positions is None:
        if _is_made(obj, state.name):
            shape_keys.remove(obj, state.name)
            _unmark(obj, state.name)
        if not state.has_keys:
            shape_keys.remove_lone_reference(obj)
        obj.arap.key_name = state.setting
        shape_keys.make_active(obj, state.active)
        obj.data.update_tag()
        return
    if len(state.positions) != len(obj.data.vertices):
        raise ValueError(
            f"'{obj.name}' has {len(obj.data.vertices)} vertices, but had {len(state.positions)}: its shape key stays"
        )
    obj.arap.key_name = state.setting
    key = ensure(obj)
    key.slider_max = state.slider_max
    key.value = state.value
    shape_keys.make_active(obj, state.active)
    shape_keys.write(obj, key, state.positions)


class KeyTracker:
    """Stays with the pose key during an interaction or Follow, also if it is renamed in Blender's list.

    Keeps names and an address to compare with, no Blender data.
    """

    def __init__(self, obj: bpy.types.Object) -> None:
        self._begun_as = name_of(obj)
        self._name = ""
        self._names: set[str] = set()
        self._address = 0

    def track(self, obj: bpy.types.Object) -> PoseKey | None:
        """Finds the pose key, by its new name if it was renamed; None if it was removed.

        Raises:
            ValueError: the pose has left the key that was followed.
        """
        found = look(obj)
        key = found.key
        is_same = key is not None and key.as_pointer() == self._address
        if key is not None and is_same and key.name == self._name:
            return found
        wanted = wanted_name(obj)
        if not is_same and self._name not in {"", wanted}:
            raise ValueError(f"{key_differs(obj.name)}, and is kept in '{self._name}'")  # else both would show it
        if key is None and _is_made(obj, wanted):
            renamed = self._renamed(obj)
            _unmark(obj, wanted)
            if renamed is None:
                # The next new key may get its address, and the artist may give its names to other keys.
                self.forget_address()
                self._names.clear()
                return None
            adopt(obj, renamed.name)
            found = look(obj)
        self.note(found.key)
        return found

    def note(self, key: bpy.types.ShapeKey | None) -> None:
        """Remembers the key as it is now. Call it when it may have been made."""
        if key is not None:
            self._name, self._address = key.name, key.as_pointer()
            self._names.add(key.name)

    def forget_address(self) -> None:
        """After an undo: everything has another address, and the key has the name of that step."""
        self._name, self._address = "", 0

    def give_name_back(self, obj: bpy.types.Object) -> None:
        """Undoes a renaming."""
        key = find(obj)
        if key is not None and key.name in self._names and key.name != self._begun_as:
            _unmark(obj, key.name)
            key.name = self._begun_as
            adopt(obj, key.name)

    def _renamed(self, obj: bpy.types.Object) -> bpy.types.ShapeKey | None:
        keys = obj.data.shape_keys.key_blocks if obj.data.shape_keys else ()
        if self._address:
            return next((key for key in keys if key.as_pointer() == self._address), None)
        # Undo has gone to the step of the renaming. The add-on saw the new name only after that step.
        return next((key for key in keys if key.name in self._names), None)


def keep_name(obj: bpy.types.Object) -> None:
    """Saves the name with the object, also if it comes from the preferences: that one may change."""
    _set_name(obj, wanted_name(obj))


def adopt(obj: bpy.types.Object, name: str) -> None:
    """Makes the key of that name the one that takes the pose, for the live session, too."""
    _mark(obj, name)
    update_session_key(obj)
    shape_keys.notify_keys_changed(obj)


def update_session_key(obj: bpy.types.Object) -> None:
    """Tells the live session, if any, which key takes the pose."""
    bound = sessions.get(obj.session_uid)
    if bound is not None:
        bound.inputs = replace(bound.inputs, key_name=name_of(obj))


def _is_made(obj: bpy.types.Object, name: str) -> bool:
    return name in obj.arap.made_keys


def _mark(obj: bpy.types.Object, name: str) -> None:
    if not _is_made(obj, name):
        obj.arap.made_keys.add().name = name
    _set_name(obj, name)


def _set_name(obj: bpy.types.Object, name: str) -> None:
    if obj.arap.key_name != name:
        obj.arap.key_name = name


def _unmark(obj: bpy.types.Object, name: str) -> None:
    index = obj.arap.made_keys.find(name)
    if index >= 0:
        obj.arap.made_keys.remove(index)
