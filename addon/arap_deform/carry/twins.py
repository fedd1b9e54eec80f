# SPDX-License-Identifier: GPL-3.0-or-later
"""The shape keys of a follower that stand for those of the mesh that it goes along with: its twins.

A twin has the name of the key that it stands for, numbered if the follower has a key of its own of that name. A driver
gives it the value of that key, and 0 while that is muted: so one slider and one animation move all. The twin of a baked
key has its keyframes, too. The driver has the last word; but an export to glTF takes animation only from keyframes.
"""

from __future__ import annotations

from collections.abc import Iterable

import bpy

from ..core.arrays import Float32s
from ..scene import baked, pose_key, shape_keys
from ..scene.seen import look
from . import twin_keyframes

# Blender works out an expression as simple as this one by itself. So no Python runs, which a file may forbid.
EXPRESSION = "value * (1 - mute)"
WIDEST = (-10.0, 10.0)  # of a slider in Blender: the body's own slider has the limits


def names_of(body: bpy.types.Object) -> list[str]:
    """The keys of the body that followers have twins of: those that the add-on has made, and its own twins."""
    keys = body.data.shape_keys
    if keys is None:
        return []
    settings = body.arap
    made = [made.name for made in (*settings.made_keys, *settings.baked_poses)]
    others = (*(pose.key_name for pose in settings.poses), *(twin.key for twin in settings.carried.twins))
    names = dict.fromkeys((*made, *others, *baked.names_of_all(body)))
    return [name for name in names if name in keys.key_blocks and name != keys.reference_key.name]


def find(target: bpy.types.Object, name: str) -> bpy.types.ShapeKey | None:
    """The twin of the body's key of that name, None if there is none."""
    item = target.arap.carried.twins.get(name)
    return shape_keys.find(target, item.key) if item is not None and item.key != _rest_name(target) else None


def _rest_name(target: bpy.types.Object) -> str:
    """Of the reference key, which is no twin, whatever a file says."""
    keys = target.data.shape_keys
    return keys.reference_key.name if keys is not None else ""


def why_hidden(body: bpy.types.Object, target: bpy.types.Object) -> str:
    """Why Blender does not show the twin of the pose, one sentence; '' if it does, or if there is none."""
    twin = find(target, pose_key.name_of(body))
    if twin is None:
        return ""
    try:
        shape_keys.check_not_hidden(target, twin)
    except ValueError as error:
        return str(error)
    return look.noted(target)


def make(body: bpy.types.Object, target: bpy.types.Object, name: str, shape: Float32s) -> bpy.types.ShapeKey:
    """A twin of the body's key of that name. ``target`` has a reference key. The caller calls tell_changed()."""
    item = target.arap.carried.twins.get(name)
    twin = _renamed(body, target, name) if item is not None else None
    if twin is None:
        with shape_keys.active_kept(target):
            twin = shape_keys.new(target, name, shape)
    else:
        shape_keys.write(target, twin, shape)
    if item is None:
        item = target.arap.carried.twins.add()
    item.name, item.key = name, twin.name
    twin.slider_min, twin.slider_max = WIDEST
    key = body.data.shape_keys.key_blocks[name]
    twin_keyframes.copy(body, key, target, twin)
    _drive(body, key, twin)
    twin.value = 0.0 if key.mute else key.value  # until the driver is evaluated
    return twin


def let_go(body: bpy.types.Object, target: bpy.types.Object) -> None:
    """A key that was renamed is the artist's own, and so is its twin then: it stays tied, under the new name."""
    twins, keys = target.arap.carried.twins, body.data.shape_keys
    if keys is None:
        return
    n_twins = len(twins)
    for index in reversed(range(n_twins)):
        name = twins[index].name
        twin = find(target, name) if shape_keys.find(body, name) is None else None
        fcurve = _driver_of(target, twin) if twin is not None else None
        paths = [path for data, path in _places(fcurve) if data == keys] if fcurve is not None else []
        key = _key_at(keys, paths[0]) if paths else None  # Blender keeps the paths up to date
        if twin is not None and key is not None:
            twin.name = key.name
            twins.remove(index)
    if len(twins) < n_twins:
        shape_keys.tell_changed(target)


def keep_only(target: bpy.types.Object, names: Iterable[str]) -> None:
    """Removes the twins of other keys."""
    twins, kept = target.arap.carried.twins, set(names)
    gone = [item.key for item in twins if item.name not in kept and item.key != _rest_name(target)]
    for index in reversed(range(len(twins))):
        if twins[index].name not in kept:
            twins.remove(index)
    if gone:
        shape_keys.remove(target, *gone)
    if not twins:
        twin_keyframes.leave(target)


def tie(body: bpy.types.Object, target: bpy.types.Object) -> None:
    """Gives a driver to the twins that have lost theirs, or have that of another body, as copies may.

    And the keyframes of their keys, if these have others now.
    """
    for item in target.arap.carried.twins:
        key, twin = shape_keys.find(body, item.name), find(target, item.name)
        if key is None or twin is None:
            continue
        fcurve = _driver_of(target, twin)
        if fcurve is None or (body.data.shape_keys, shape_keys.value_path(key)) not in _places(fcurve):
            _drive(body, key, twin)
        twin_keyframes.copy(body, key, target, twin)


def _driver_of(target: bpy.types.Object, twin: bpy.types.ShapeKey) -> bpy.types.FCurve | None:
    animation = target.data.shape_keys.animation_data
    return animation.drivers.find(shape_keys.value_path(twin)) if animation is not None else None


def _places(fcurve: bpy.types.FCurve) -> list[tuple[bpy.types.ID, str]]:
    """What a driver reads: data, and paths in it."""
    return [(place.id, place.data_path) for variable in fcurve.driver.variables for place in variable.targets]


def are_all_there(body: bpy.types.Object, target: bpy.types.Object) -> bool:
    """Whether each twin is there with its key. Quick, as each evaluation asks it."""
    twins = target.arap.carried.twins
    if not twins:
        return True
    of_body, own = (set(obj.data.shape_keys.key_blocks.keys()) if obj.data.shape_keys else () for obj in (body, target))
    return all(item.name in of_body and item.key in own for item in twins)


def _renamed(body: bpy.types.Object, target: bpy.types.Object, name: str) -> bpy.types.ShapeKey | None:
    """The twin, if the artist has given it another name: its driver tells. A second one would add to it."""
    keys, path = target.data.shape_keys, shape_keys.value_path(shape_keys.find(body, name))
    for fcurve in keys.animation_data.drivers if keys.animation_data else ():
        if fcurve.driver.expression == EXPRESSION and (body.data.shape_keys, path) in _places(fcurve):
            found = _key_at(keys, fcurve.data_path)
            if found is not None and found.name != _rest_name(target):
                return found
    return None


def _key_at(keys: bpy.types.Key, path: str) -> bpy.types.ShapeKey | None:
    """The key of which ``path`` is a property; None if it is gone."""
    try:
        return keys.path_resolve(path.rpartition(".")[0])
    except ValueError:
        return None


def _drive(body: bpy.types.Object, key: bpy.types.ShapeKey, twin: bpy.types.ShapeKey) -> None:
    driver = twin.driver_add("value").driver
    for variable in list(driver.variables):
        driver.variables.remove(variable)
    path = shape_keys.value_path(key)
    for name in ("value", "mute"):
        variable = driver.variables.new()
        variable.name, variable.type = name, "SINGLE_PROP"
        place = variable.targets[0]
        place.id_type, place.id = "KEY", body.data.shape_keys
        place.data_path = f"{path.rpartition('.')[0]}.{name}"
    driver.type, driver.expression = "SCRIPTED", EXPRESSION
