# SPDX-License-Identifier: GPL-3.0-or-later
"""The linked keys of an attached object: its shape keys that stand for those of its host.

A linked key has the name of the host's key, numbered if the object has a key of its own of that name. A driver gives it
the value of that key, and 0 while that is muted: so one slider and one animation move all. The linked key of a baked
key has its keyframes, too. The driver has the last word; but an export to glTF takes animation only from keyframes.
"""

from __future__ import annotations

from collections.abc import Iterable

import bpy

from ..core.arrays import Float32s
from ..scene import baked, pose_key, shape_keys
from ..scene.seen import look
from . import linked_keyframes

# Blender works out an expression as simple as this one by itself. So no Python runs, which a file may forbid.
EXPRESSION = "value * (1 - mute)"
WIDEST = (-10.0, 10.0)  # of a slider in Blender: the host's own slider has the limits


def names_of(host: bpy.types.Object) -> list[str]:
    """The keys of the host that are linked: those that the add-on has made, and its own linked keys."""
    keys = host.data.shape_keys
    if keys is None:
        return []
    settings = host.arap
    made = [made.name for made in (*settings.made_keys, *settings.baked_poses)]
    others = (*(pose.key_name for pose in settings.poses), *(linked.key for linked in settings.attached_to.linked_keys))
    names = dict.fromkeys((*made, *others, *baked.names_of_all(host)))
    return [name for name in names if name in keys.key_blocks and name != keys.reference_key.name]


def find(attached: bpy.types.Object, name: str) -> bpy.types.ShapeKey | None:
    """The key that is linked to the host's key of that name, None if there is none."""
    item = attached.arap.attached_to.linked_keys.get(name)
    return shape_keys.find(attached, item.key) if item is not None and item.key != _rest_name(attached) else None


def _rest_name(attached: bpy.types.Object) -> str:
    """The name of the reference key, which is no linked key, whatever a file says."""
    keys = attached.data.shape_keys
    return keys.reference_key.name if keys is not None else ""


def why_hidden(host: bpy.types.Object, attached: bpy.types.Object) -> str:
    """Why Blender does not show the linked key of the pose, one sentence; '' if it does, or if there is none."""
    linked = find(attached, pose_key.name_of(host))
    if linked is None:
        return ""
    try:
        shape_keys.check_not_hidden(attached, linked)
    except ValueError as error:
        return str(error)
    return look.noted(attached)


def make(host: bpy.types.Object, attached: bpy.types.Object, name: str, shape: Float32s) -> bpy.types.ShapeKey:
    """Makes the key that is linked to the host's key of that name. The caller calls notify_keys_changed().

    Args:
        attached: has a reference key.
    """
    item = attached.arap.attached_to.linked_keys.get(name)
    linked = _renamed(host, attached, name) if item is not None else None
    if linked is None:
        with shape_keys.active_kept(attached):
            linked = shape_keys.new(attached, name, shape)
    else:
        shape_keys.write(attached, linked, shape)
    if item is None:
        item = attached.arap.attached_to.linked_keys.add()
    item.name, item.key = name, linked.name
    linked.slider_min, linked.slider_max = WIDEST
    key = host.data.shape_keys.key_blocks[name]
    linked_keyframes.copy(host, key, attached, linked)
    _drive(host, key, linked)
    linked.value = 0.0 if key.mute else key.value  # until the driver is evaluated
    return linked


def release_renamed(host: bpy.types.Object, attached: bpy.types.Object) -> None:
    """Gives the artist linked keys whose host's key was renamed. They take the new name, and keep their drivers."""
    linked_keys, keys = attached.arap.attached_to.linked_keys, host.data.shape_keys
    if keys is None:
        return
    n_before = len(linked_keys)
    for index in reversed(range(n_before)):
        name = linked_keys[index].name
        linked = find(attached, name) if shape_keys.find(host, name) is None else None
        fcurve = _driver_of(attached, linked) if linked is not None else None
        paths = [path for data, path in _places(fcurve) if data == keys] if fcurve is not None else []
        key = _key_at(keys, paths[0]) if paths else None  # Blender keeps the paths up to date
        if linked is not None and key is not None:
            linked.name = key.name
            linked_keys.remove(index)
    if len(linked_keys) < n_before:
        shape_keys.notify_keys_changed(attached)


def keep_only(attached: bpy.types.Object, names: Iterable[str]) -> None:
    """Removes the linked keys of other names."""
    linked_keys, kept = attached.arap.attached_to.linked_keys, set(names)
    gone = [item.key for item in linked_keys if item.name not in kept and item.key != _rest_name(attached)]
    for index in reversed(range(len(linked_keys))):
        if linked_keys[index].name not in kept:
            linked_keys.remove(index)
    if gone:
        shape_keys.remove(attached, *gone)
    if not linked_keys:
        linked_keyframes.leave(attached)


def add_drivers(host: bpy.types.Object, attached: bpy.types.Object) -> None:
    """Adds the drivers of linked keys that are lost or read another host, as those of copies may. Copies keyframes."""
    for item in attached.arap.attached_to.linked_keys:
        key, linked = shape_keys.find(host, item.name), find(attached, item.name)
        if key is None or linked is None:
            continue
        fcurve = _driver_of(attached, linked)
        if fcurve is None or (host.data.shape_keys, shape_keys.value_path(key)) not in _places(fcurve):
            _drive(host, key, linked)
        linked_keyframes.copy(host, key, attached, linked)


def _driver_of(attached: bpy.types.Object, linked: bpy.types.ShapeKey) -> bpy.types.FCurve | None:
    animation = attached.data.shape_keys.animation_data
    return animation.drivers.find(shape_keys.value_path(linked)) if animation is not None else None


def _places(fcurve: bpy.types.FCurve) -> list[tuple[bpy.types.ID, str]]:
    """What a driver reads: data, and paths in it."""
    return [(place.id, place.data_path) for variable in fcurve.driver.variables for place in variable.targets]


def are_all_there(host: bpy.types.Object, attached: bpy.types.Object) -> bool:
    """Whether each linked key and its host's key are there. Quick, as each evaluation asks it."""
    linked_keys = attached.arap.attached_to.linked_keys
    if not linked_keys:
        return True
    of_host, own = (
        set(obj.data.shape_keys.key_blocks.keys()) if obj.data.shape_keys else () for obj in (host, attached)
    )
    return all(item.name in of_host and item.key in own for item in linked_keys)


def _renamed(host: bpy.types.Object, attached: bpy.types.Object, name: str) -> bpy.types.ShapeKey | None:
    """The linked key, if the artist has given it another name: its driver tells. A second one would add to it."""
    keys, path = attached.data.shape_keys, shape_keys.value_path(shape_keys.find(host, name))
    for fcurve in keys.animation_data.drivers if keys.animation_data else ():
        if fcurve.driver.expression == EXPRESSION and (host.data.shape_keys, path) in _places(fcurve):
            found = _key_at(keys, fcurve.data_path)
            if found is not None and found.name != _rest_name(attached):
                return found
    return None


def _key_at(keys: bpy.types.Key, path: str) -> bpy.types.ShapeKey | None:
    """The key of which ``path`` is a property; None if it is gone."""
    try:
        return keys.path_resolve(path.rpartition(".")[0])
    except ValueError:
        return None


def _drive(host: bpy.types.Object, key: bpy.types.ShapeKey, linked: bpy.types.ShapeKey) -> None:
    driver = linked.driver_add("value").driver
    for variable in list(driver.variables):
        driver.variables.remove(variable)
    path = shape_keys.value_path(key)
    for name in ("value", "mute"):
        variable = driver.variables.new()
        variable.name, variable.type = name, "SINGLE_PROP"
        place = variable.targets[0]
        place.id_type, place.id = "KEY", host.data.shape_keys
        place.data_path = f"{path.rpartition('.')[0]}.{name}"
    driver.type, driver.expression = "SCRIPTED", EXPRESSION
