# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays to shape keys and their keyframes. Only this file writes coordinates, and it tells so: see props/hooks."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager

import bpy

from ..core import naming
from ..core.arrays import Float32s
from ..props import hooks
from . import fcurves, meshes, versions
from .points import objects as points

FRAME_PATTERN = r"(?:-\d{3,}|\d{4,})"  # what frame_key_name() puts behind the prefix


def check_writable(obj: bpy.types.Object) -> None:
    """Raises ValueError if shape keys of this mesh or curve must not be written, and says what to do."""
    data = obj.data
    meshes.check_local(obj)
    if reason := why_shared(obj):
        raise ValueError(reason)
    if data.shape_keys is not None and not data.shape_keys.use_relative:
        raise ValueError(f"The shape keys of '{obj.name}' are absolute: turn on Relative in the shape keys panel")


def why_shared(obj: bpy.types.Object) -> str:
    """Why a pose would deform other objects too, one sentence; '' if it would not."""
    data = obj.data
    # Users are not only objects (a fake user, a pointer of another add-on), so look if there are several.
    if data.users < 2 or sum(other.data == data for other in bpy.data.objects) < 2:
        return ""
    return (
        f"The {obj.type.lower()} of '{obj.name}' is shared with other objects, which would deform too: make it "
        "single-user (Object > Relations > Make Single User > Object & Data)"
    )


def check_animatable(obj: bpy.types.Object) -> None:
    """Raises ValueError if the values of shape keys cannot take keyframes, and says what to do."""
    animation = obj.data.shape_keys.animation_data if obj.data.shape_keys else None
    if animation and animation.action and animation.action.library:
        raise ValueError(
            f"The animation of the shape keys of '{obj.name}', action '{animation.action.name}', is linked from "
            "another file: make it local or take it off"
        )
    if animation and animation.action and fcurves.is_action_shared(obj.data.shape_keys):
        raise ValueError(
            f"The animation of the shape keys of '{obj.name}', action '{animation.action.name}', moves other data too, "
            "which would change: make the action single-user"
        )


def check_shown(obj: bpy.types.Object, key: bpy.types.ShapeKey) -> None:
    """Raises ValueError if Blender would not show what is written to ``key``, and says what to do."""
    check_not_hidden(obj, key)
    keys = obj.data.shape_keys
    if keys.animation_data is not None and fcurves.is_animated(keys, value_path(key)):
        raise ValueError(
            f"The value of shape key '{key.name}' of '{obj.name}' is animated: delete its keyframes or driver"
        )


def check_not_hidden(obj: bpy.types.Object, key: bpy.types.ShapeKey) -> None:
    """As check_shown(), whatever the value of ``key`` is."""
    keys = obj.data.shape_keys
    if key.mute:
        raise ValueError(
            f"Shape key '{key.name}' of '{obj.name}' is muted, so the pose would not show: "
            "press Edit Again after a bake, else unmute it"
        )
    check_none_alone(obj, key)
    if key.relative_key != keys.reference_key:
        raise ValueError(
            f"Shape key '{key.name}' of '{obj.name}' is relative to '{key.relative_key.name}': "
            f"set Relative To to '{keys.reference_key.name}'"
        )
    if key.vertex_group:
        raise ValueError(
            f"Shape key '{key.name}' of '{obj.name}' is limited to vertex group '{key.vertex_group}': clear that field"
        )


def check_none_alone(obj: bpy.types.Object, key: bpy.types.ShapeKey | None) -> None:
    """Raises ValueError if the object shows a cache or another key alone. ``key``: None is one that will be made."""
    for modifier in obj.modifiers:
        if hides_keys(modifier):
            raise ValueError(
                f"Modifier '{modifier.name}' of '{obj.name}' shows a cache in place of the pose: switch it off, in "
                "viewports and renders"
            )
    if obj.show_only_shape_key and obj.active_shape_key != key:
        raise ValueError(f"'{obj.name}' shows another shape key alone: turn off Shape Key Lock (the pin icon)")


def hides_keys(modifier: bpy.types.Modifier) -> bool:
    """Whether a modifier takes the place of every vertex from a file, in viewports or in renders."""
    return bool(
        modifier.type == "MESH_CACHE"
        and meshes.is_switched_on(modifier)
        and modifier.deform_mode == "OVERWRITE"
        and modifier.factor == 1.0
        and modifier.filepath
        and not getattr(modifier, "vertex_group", "")
    )


def find(obj: bpy.types.Object, name: str) -> bpy.types.ShapeKey | None:
    """The key of that name, None if there is none."""
    keys = obj.data.shape_keys
    return keys.key_blocks.get(name) if keys else None


def free_name(obj: bpy.types.Object, name: str) -> str:
    """The first of name.001, name.002 ... that no key of the mesh has."""
    keys = obj.data.shape_keys
    return naming.numbered(re.sub(r"\.\d+$", "", name), keys.key_blocks.keys() if keys else ())


def add(obj: bpy.types.Object, name: str) -> bpy.types.ShapeKey:
    """A new key at rest, with Basis if the mesh has no keys."""
    ensure_reference(obj)
    return new(obj, name, meshes.read_rest(obj))


def ensure_reference(obj: bpy.types.Object) -> None:
    """Makes Basis if the mesh has no keys."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis", from_mix=False)


def new(obj: bpy.types.Object, name: str, positions: Float32s) -> bpy.types.ShapeKey:
    """A new key, relative to the rest shape, value 0. Blender may make the name unique.

    When the caller has noted what the key is for, it calls notify_keys_changed(). So it is with add() and add_all().
    """
    key = obj.shape_key_add(name=naming.cut(name), from_mix=False)
    key.value = 0.0  # 5.0 and later start at 1
    key.relative_key = obj.data.shape_keys.reference_key
    versions.write_key(key, positions)
    obj.data.update_tag()
    return key


def add_all(obj: bpy.types.Object, names: Iterable[str], shapes: Iterable[Float32s]) -> list[str]:
    """A new key for each name and shape, as new(), with Basis if the mesh has no keys; returns their names.

    If Blender runs out of memory half way, or ``shapes`` raises, the new keys are removed again.
    """
    had_keys = obj.data.shape_keys is not None
    ensure_reference(obj)
    made: list[str] = []
    try:
        for name, shape in zip(names, shapes, strict=True):
            made.append(new(obj, name, shape).name)
    except BaseException:
        _remove(obj, made)
        if not had_keys:
            remove_lone_reference(obj)
        raise
    return made


def write(obj: bpy.types.Object, key: bpy.types.ShapeKey, positions: Float32s, *, is_frame: bool = False) -> None:
    """Writes (n, 3) contiguous float32 and has Blender show it. ``is_frame``: see hooks.key_written.

    Keys that are relative to this one go along: they keep what they add to it.
    """
    _write(obj, key, positions, _bases(obj), is_frame=is_frame)


def _write(
    obj: bpy.types.Object, key: bpy.types.ShapeKey, positions: Float32s, bases: set[str], *, is_frame: bool
) -> None:
    """As write(). ``bases``: from _bases()."""
    if key.name in bases:
        _shift(_relative_to(obj, key), key, positions)
    versions.write_key(key, positions)
    obj.data.update_tag()
    for written in hooks.key_written:
        written(obj, key, positions, is_frame)


def notify_keys_changed(obj: bpy.types.Object) -> None:
    """Keys have come or gone, or have other names or keyframes: tells later rooms."""
    for changed in hooks.keys_changed:
        changed(obj)


def show(key: bpy.types.ShapeKey) -> None:
    """Sets the slider to 1."""
    if key.value != 1.0:
        key.slider_max = max(key.slider_max, 1.0)
        key.value = 1.0


def remove(obj: bpy.types.Object, *names: str) -> None:
    """Removes keys with what animates them. Passes over those that are not there. As _remove()."""
    _remove(obj, names)
    notify_keys_changed(obj)


def _remove(obj: bpy.types.Object, names: Iterable[str]) -> None:
    """What is relative to a key that goes is relative to rest then, and adds what it did."""
    keys = obj.data.shape_keys
    bases = _bases(obj)
    for name in names:
        key = find(obj, name)
        if key is None:
            continue
        if name in bases and key != keys.reference_key:
            _shift(_relative_to(obj, key), key, meshes.read_rest(obj))
            for other in keys.key_blocks:
                if other.relative_key == key:
                    other.relative_key = keys.reference_key
        # Before the key: Blender 4.5 takes its driver away from under the next evaluation, and that crashes.
        fcurves.remove_animation(keys, value_path(key))
        with active_kept(obj):
            obj.shape_key_remove(key)


def _bases(obj: bpy.types.Object) -> set[str]:
    """Names of the keys that others are relative to. One look for all: among a thousand keys each takes long."""
    keys = obj.data.shape_keys
    return {key.relative_key.name for key in keys.key_blocks} if keys is not None else set()


def _relative_to(obj: bpy.types.Object, key: bpy.types.ShapeKey) -> list[bpy.types.ShapeKey]:
    """The keys that are relative to ``key``, those that are relative to these, and so on; but not the reference."""
    keys = obj.data.shape_keys
    found = [key]
    for base in found if key != keys.reference_key else ():  # which grows
        found += [k for k in keys.key_blocks if k.relative_key == base and k != keys.reference_key and k not in found]
    return found[1:]


def _shift(others: Iterable[bpy.types.ShapeKey], key: bpy.types.ShapeKey, positions: Float32s) -> None:
    """Moves other keys as ``key`` moves, which will have these positions, or whose place another key takes."""
    shift = None
    for other in others:
        shift = positions - versions.read_key(key) if shift is None else shift
        versions.write_key(other, versions.read_key(other) + shift)


@contextmanager
def active_kept(obj: bpy.types.Object) -> Iterator[None]:
    """Keeps the active key, by name, while other keys come and go."""
    name = active_name(obj)
    try:
        yield
    finally:
        make_active(obj, name)


def remove_lone_reference(obj: bpy.types.Object) -> None:
    """Removes the reference key if it is the only one."""
    keys = obj.data.shape_keys
    if keys is not None and len(keys.key_blocks) == 1:
        obj.shape_key_remove(keys.reference_key)


def active_name(obj: bpy.types.Object) -> str:
    """Name of the key chosen in the list, '' if there is none."""
    key = obj.active_shape_key
    return key.name if key is not None else ""


def make_active(obj: bpy.types.Object, name: str) -> None:
    """Chooses the key of that name in the list, if there is one."""
    keys = obj.data.shape_keys
    index = keys.key_blocks.find(name) if keys else -1
    if index >= 0:
        obj.active_shape_key_index = index


def value_path(key: bpy.types.ShapeKey) -> str:
    """Path of the key's value from the shape keys' data-block."""
    return f'key_blocks["{bpy.utils.escape_identifier(key.name)}"].value'


def shift_all(obj: bpy.types.Object, pose: bpy.types.ShapeKey, shape: Float32s) -> None:
    """Makes ``shape`` the rest shape and the shape of ``pose``; other keys keep their offsets.

    Args:
        pose: the pose key.
        shape: (n, 3) contiguous float32, what it shows.

    Raises:
        ValueError: as hooks.rest_changes; nothing has changed.
    """
    for changes in hooks.rest_changes:
        changes(obj, pose)
    keys = obj.data.shape_keys
    shift_of_pose = shape - versions.read_key(pose)
    shift = shape - versions.read_key(keys.reference_key)
    for key in keys.key_blocks:
        if key not in (pose, keys.reference_key):
            # Keys relative to the pose go with it.
            is_on_pose = _root_of(key, keys.reference_key, pose) == pose
            versions.write_key(key, versions.read_key(key) + (shift_of_pose if is_on_pose else shift))
    versions.write_key(pose, shape)
    versions.write_key(keys.reference_key, shape)
    points.write_positions(obj.data, shape)
    obj.data.update_tag()
    notify_keys_changed(obj)


def _root_of(
    key: bpy.types.ShapeKey, reference: bpy.types.ShapeKey, pose: bpy.types.ShapeKey
) -> bpy.types.ShapeKey | None:
    """The pose or the reference, the first that the chain of relative keys meets; None if the chain is a circle."""
    seen: list[bpy.types.ShapeKey] = []
    while key not in seen:
        if key in (reference, pose):
            return key
        seen.append(key)
        key = key.relative_key
    return None


def frame_key_name(prefix: str, frame: int) -> str:
    """Name of the key of a baked frame."""
    return f"{prefix}{frame:04d}"


def frame_keys(obj: bpy.types.Object, prefix: str) -> Iterator[str]:
    """Names of the keys that an earlier bake with this prefix made: their values have keyframes."""
    keys = obj.data.shape_keys
    pattern = re.compile(re.escape(prefix) + FRAME_PATTERN)
    for key in keys.key_blocks if keys else ():
        if pattern.fullmatch(key.name) and fcurves.has_fcurve(keys, value_path(key)):
            yield key.name


def write_animation(
    obj: bpy.types.Object, prefix: str, frames: Sequence[int], shape_of: Callable[[int], Float32s], time_scale: float
) -> list[str]:
    """One key for each frame. At its frame only this key shows, with value 1, and neighbours blend linearly.

    Keys of an earlier bake with the same prefix are written again, or go. The caller calls notify_keys_changed() at the
    end, see new(). No key gets another name: then Blender searches all animation of the file.

    Args:
        shape_of: (n, 3) of a frame by its index.
        time_scale: see fcurves.time_scale().
    """
    former, active = set(frame_keys(obj, prefix)), active_name(obj)
    names = [frame_key_name(prefix, frame) for frame in frames]
    # New keys first: if memory runs out for them, nothing has changed.
    new_ones = [i for i, name in enumerate(names) if name not in former]
    made = add_all(obj, (names[i] for i in new_ones), (shape_of(i) for i in new_ones))
    for i, name in zip(new_ones, made, strict=True):
        names[i] = name
    _remove(obj, former.difference(names))
    notify_keys_changed(obj)
    keys, bases = obj.data.shape_keys, _bases(obj)
    for i, name in enumerate(names):
        key = keys.key_blocks[name]
        if name in former:
            fcurves.remove_animation(keys, value_path(key))
            _make_plain(key, keys.reference_key)
            _write(obj, key, shape_of(i), bases, is_frame=False)
        around = [(k, float(k == i)) for k in (i - 1, i, i + 1) if 0 <= k < len(frames)]
        keyframes = [(frames[k] * time_scale, value) for k, value in around]
        fcurves.insert_linear_keyframes(keys, key, value_path(key), keyframes)
    make_active(obj, active)
    return names


def _make_plain(key: bpy.types.ShapeKey, reference: bpy.types.ShapeKey) -> None:
    """Takes away what the artist has set on a key."""
    key.mute, key.vertex_group, key.relative_key = False, "", reference
    key.slider_min, key.slider_max, key.value = 0.0, 1.0, 0.0
