# SPDX-License-Identifier: GPL-3.0-or-later
"""The live key: the shape key that takes the pose of an object. Which one it is, and what Esc gives back.

It has the name in ``obj.arap`` and is one that the add-on has made (``made_keys``): a key of the artist's own that has
the name by chance is left alone, and the live key takes the next free name, as Blender names things.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import bpy

from ..core import sessions
from ..core.arrays import Float32s
from . import shape_keys


@dataclass(frozen=True)
class KeyState:
    """What restore() brings back; no Blender data.

    Attributes:
        name: of the live key, or the one it would have had.
        setting: the name in ``obj.arap``, '' where it is that of the preferences.
        has_keys: whether the mesh had any shape key, Basis included.
        positions: (n, 3) float32 of the key, None where there was none.
        active: the key chosen in the list, '' where there was none.
    """

    name: str
    setting: str
    has_keys: bool
    positions: Float32s | None = None
    value: float = 0.0
    slider_max: float = 1.0
    active: str = ""


def check_name(obj: bpy.types.Object) -> None:
    """Raises ValueError where the name in ``obj.arap`` cannot be the live key's."""
    name = obj.arap.key_name
    keys = obj.data.shape_keys
    if keys is not None and keys.reference_key.name == name:
        raise ValueError(f"Shape key '{name}' of '{obj.name}' is its rest shape: choose another name for the pose")


def find(obj: bpy.types.Object) -> bpy.types.ShapeKey | None:
    """The live key, None where there is none yet."""
    name = obj.arap.key_name
    return shape_keys.find(obj, name) if _is_made(obj, name) else None


def name_of(obj: bpy.types.Object) -> str:
    """The live key's name, or the one it will have: that in ``obj.arap``, numbered where another key has it."""
    name = str(obj.arap.key_name)
    if shape_keys.find(obj, name) is None or _is_made(obj, name):
        return name
    return shape_keys.free_name(obj, name)


def ensure(obj: bpy.types.Object) -> bpy.types.ShapeKey:
    """The live key, made at rest (value 0) where missing, with Basis where the mesh has no keys."""
    key = find(obj)
    if key is None:
        key = shape_keys.add(obj, name_of(obj))
        _mark(obj, key.name)
    return key


def forget_removed(obj: bpy.types.Object) -> None:
    """Forgets keys that somebody has removed or renamed in Blender's list: another of that name is not ours."""
    made = obj.arap.made_keys
    for index in reversed(range(len(made))):
        if shape_keys.find(obj, made[index].name) is None:
            made.remove(index)


def capture(obj: bpy.types.Object) -> KeyState:
    """The state of the live key."""
    key = find(obj)
    keys = obj.data.shape_keys
    state = KeyState(name_of(obj), obj.arap.own_key_name, keys is not None, active=shape_keys.active_name(obj))
    if key is None:
        return state
    return replace(state, positions=shape_keys.read(key), value=key.value, slider_max=key.slider_max)


def restore(obj: bpy.types.Object, state: KeyState) -> None:
    """Back to ``state``: keys that were not there go.

    Raises:
        ValueError: the mesh has another number of vertices by now; nothing is written.
    """
    if state.positions is None:
        if _is_made(obj, state.name):
            shape_keys.remove(obj, state.name)
            _unmark(obj, state.name)
        if not state.has_keys:
            shape_keys.remove_lone_reference(obj)
        obj.arap.own_key_name = state.setting
        shape_keys.make_active(obj, state.active)
        obj.data.update_tag()
        return
    if len(state.positions) != len(obj.data.vertices):
        raise ValueError(
            f"'{obj.name}' has {len(obj.data.vertices)} vertices, but had {len(state.positions)}: its shape key stays"
        )
    obj.arap.own_key_name = state.setting
    key = ensure(obj)
    key.slider_max = state.slider_max
    key.value = state.value
    shape_keys.make_active(obj, state.active)
    shape_keys.write(obj, key, state.positions)


class KeyFollower:
    """Keeps to the live key during a posing act or Live, also where somebody renames it in Blender's list.

    Holds names and an address to compare with, no Blender data.
    """

    def __init__(self, obj: bpy.types.Object) -> None:
        self._begun_as = name_of(obj)
        self._name = ""
        self._names: set[str] = set()
        self._address = 0

    def why_left(self, obj: bpy.types.Object) -> str:
        """Why the pose is no longer of the key that was followed, without a full stop; '' while it is."""
        key = find(obj)
        if self._name in {"", obj.arap.key_name} or (key is not None and key.as_pointer() == self._address):
            return ""
        return f"{sessions.key_differs(obj.name)}, and is kept in '{self._name}'"

    def follow(self, obj: bpy.types.Object) -> bool:
        """Goes along where somebody has renamed the key; False where it was removed."""
        setting = obj.arap.key_name
        if find(obj) is None and _is_made(obj, setting):
            key = self._renamed(obj)
            if key is None:
                # The next key that is made may have its address, and one of the names is the artist's to give again.
                self.forget_address()
                self._names.clear()
                _unmark(obj, setting)
                return False
            _unmark(obj, setting)
            adopt(obj, key.name)
        self.note(obj)
        return True

    def note(self, obj: bpy.types.Object) -> None:
        """Remembers the key as it is now; to be called once it may have been made."""
        key = find(obj)
        if key is not None:
            self._name, self._address = key.name, key.as_pointer()
            self._names.add(key.name)

    def forget_address(self) -> None:
        """After an undo: everything has another address then, and the key the name it had at that step."""
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
        # Undo has gone to the step of the renaming itself, which the add-on saw only after it.
        return next((key for key in keys if key.name in self._names), None)


def keep_name(obj: bpy.types.Object) -> None:
    """Saves the name with the object, also where it is that of the preferences, which may be another one tomorrow."""
    _set_name(obj, obj.arap.key_name)


def adopt(obj: bpy.types.Object, name: str) -> None:
    """Makes the key of that name the live one, for the live session too."""
    _mark(obj, name)
    tell_session(obj)


def tell_session(obj: bpy.types.Object) -> None:
    """Tells the live session, if any, which key is the live one."""
    bound = sessions.get(obj.name)
    if bound is not None:
        bound.inputs = replace(bound.inputs, key_name=name_of(obj))


def _is_made(obj: bpy.types.Object, name: str) -> bool:
    return name in obj.arap.made_keys


def _mark(obj: bpy.types.Object, name: str) -> None:
    if not _is_made(obj, name):
        obj.arap.made_keys.add().name = name
    _set_name(obj, name)


def _set_name(obj: bpy.types.Object, name: str) -> None:
    if obj.arap.own_key_name != name:
        obj.arap.own_key_name = name


def _unmark(obj: bpy.types.Object, name: str) -> None:
    index = obj.arap.made_keys.find(name)
    if index >= 0:
        obj.arap.made_keys.remove(index)
