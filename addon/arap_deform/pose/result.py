# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes of a pose: a key of its own, the new rest shape, nothing; and the way back on Esc."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import bpy
from numpy.typing import NDArray

from ..core import sessions
from ..scene import handle_motion, meshes, pose_key, rest, shape_keys

Transforms = dict[tuple[str, str], tuple[Any, ...]]  # channels by name of object and bone ('': the object)

CHANNELS = ("location", "rotation_mode", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale")


@dataclass(frozen=True)
class PoseState:
    """What the posing act gives back on Esc; no Blender data.

    Attributes:
        key: values and slider of the live key.
        transforms: of everything that an artist may have moved to move a handle.
    """

    object_name: str
    key: pose_key.KeyState
    transforms: Transforms


def bake_pose(obj: bpy.types.Object, name: str = "Pose") -> bpy.types.ShapeKey:
    """Copies the pose that the live key shows to a new key (value 0); the live key stays.

    Raises:
        ValueError: there is no pose yet, the live key does not show it, or the mesh must not be written.
    """
    shape_keys.check_shown(obj, _live_key(obj))
    if not name:
        raise ValueError("The baked pose needs a name: type one, for example Pose")
    return shape_keys.new(obj, name, handle_motion.shown_positions(obj, shape_keys.read_reference(obj)))


def reset_pose(obj: bpy.types.Object) -> None:
    """Puts the live key, and the session, back to rest. Handles stay where they are: see reset_handles.

    Raises:
        ValueError: the mesh must not be written. RuntimeError: an act has it for itself.
    """
    meshes.check_mesh(obj)
    sessions.check_free(obj.name)
    shape_keys.check_writable(obj)
    key = pose_key.find(obj)
    if key is not None:
        pose_key.check_name(obj)
        shape_keys.write(obj, key, shape_keys.read_reference(obj))
    bound = sessions.get(obj.name)
    if bound is not None:
        bound.session.reset()


def apply_pose_as_rest(obj: bpy.types.Object) -> None:
    """Makes the pose shown the new rest shape: Basis takes it, other keys keep their offsets, handles are at rest here.

    Stored poses put the handles where they did before.

    Raises:
        ValueError: there is no pose yet, the live key does not show it, or the mesh must not be written.
        RuntimeError: an act has the mesh for itself.
    """
    key = _live_key(obj)
    sessions.check_free(obj.name)
    shape_keys.check_shown(obj, key)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    meshes.read_stretch(obj, depsgraph)  # refuses before anything has changed
    shape_keys.shift_all(obj, key, handle_motion.shown_positions(obj, shape_keys.read_reference(obj)))
    rests = rest.rest_matrices(obj)
    rest.set_rest_here(obj, depsgraph)
    rest.follow_new_rest(obj, rests)
    sessions.drop(obj.name)


def capture_state(obj: bpy.types.Object) -> PoseState:
    """What restore_state() brings back."""
    return PoseState(obj.name, pose_key.capture(obj), capture_transforms(obj))


def restore_state(obj: bpy.types.Object, state: PoseState) -> None:
    """Back to ``state``: the handles' transforms, the key (removed where there was none), its slider, the session.

    Objects and bones that are gone are passed over.

    Raises:
        ValueError: the mesh has another number of vertices by now; then only the handles go back.
        RuntimeError: an act has the mesh for itself; then nothing goes back.
    """
    sessions.check_free(obj.name)
    restore_transforms(state.transforms)
    pose_key.restore(obj, state.key)
    bound = sessions.get(obj.name)
    if bound is None:
        return
    positions: NDArray[Any] | None = state.key.positions
    if positions is None:
        bound.session.reset()
    else:
        bound.session.set_positions(positions)


def capture_transforms(obj: bpy.types.Object) -> Transforms:
    """Channels of the handles' objects, of their parents, and of all bones of their armatures."""
    return {place: _channels(item) for place, item in _movers(obj)}


def restore_transforms(transforms: Transforms) -> None:
    """Back to what capture_transforms() returned, where it is still there."""
    for (object_name, bone), channels in transforms.items():
        item = _item_at(object_name, bone)
        if item is not None:
            _set_channels(item, channels)


def _live_key(obj: bpy.types.Object) -> bpy.types.ShapeKey:
    meshes.check_mesh(obj)
    shape_keys.check_writable(obj)
    pose_key.check_name(obj)
    key = pose_key.find(obj)
    if key is None:
        raise ValueError(f"'{obj.name}' has no pose yet: pose it first")
    return key


def _movers(obj: bpy.types.Object) -> Iterator[tuple[tuple[str, str], Any]]:
    """Everything an artist may have moved to move a handle: its object and its parents; all bones of its armature."""
    seen: set[str] = {obj.name}
    for handle in obj.arap.handles:
        item = handle.target
        while item is not None and item.name not in seen:
            seen.add(item.name)
            yield (item.name, ""), item
            if item.type == "ARMATURE":
                for bone in item.pose.bones:
                    yield (item.name, bone.name), bone
            item = item.parent


def _item_at(object_name: str, bone: str) -> Any:
    item = bpy.data.objects.get(object_name)
    if item is None or not bone:
        return item
    return item.pose.bones.get(bone) if item.pose else None


def _channels(item: Any) -> tuple[Any, ...]:
    values = (getattr(item, name) for name in CHANNELS)
    return tuple(value if isinstance(value, str) else tuple(value) for value in values)


def _set_channels(item: Any, channels: tuple[Any, ...]) -> None:
    if channels != _channels(item):
        for name, value in zip(CHANNELS, channels, strict=True):
            setattr(item, name, value)
