# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes of a pose: a shape key, the new rest shape, or nothing; and the way back on Esc."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
from mathutils import Matrix

from ..core import sessions
from ..core.arrays import Floats
from ..core.transforms import inverted
from ..scene import handle_motion, known, meshes, placing, pose_key, preserve_shape, shape_keys
from ..scene.movers import chain
from ..setup.control_changes import rebase

Transforms = dict[tuple[int, str], tuple[Any, ...]]  # channels by uid of object and bone; bone '': the object itself

CHANNELS = ("location", "rotation_mode", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale")


@dataclass(frozen=True)
class PoseState:
    """What Esc restores; no Blender data.

    Attributes:
        key: values and slider of the pose key.
        transforms: of every object and bone that moves a handle.
        bases: of pins and handles.
    """

    uid: int
    key: pose_key.KeyState
    transforms: Transforms
    bases: preserve_shape.Bases


def bake_pose(obj: bpy.types.Object, name: str = "Pose") -> bpy.types.ShapeKey:
    """Copies the pose that the pose key shows to a new shape key with value 0. The pose key stays.

    Raises:
        ValueError: there is no pose, the pose key does not show it, or the mesh must not be written.
    """
    shape_keys.check_shown(obj, _pose_key(obj))
    if not name:
        raise ValueError("The baked pose needs a name: type one, for example Pose")
    key = shape_keys.new(obj, name, pose_key.shown_positions(obj, meshes.read_rest(obj)))
    obj.arap.baked_poses.add().name = key.name
    shape_keys.notify_keys_changed(obj)
    return key


def reset_pose(obj: bpy.types.Object) -> None:
    """Puts the pose key and the session back to rest. The handles stay: see reset_handles().

    Raises:
        ValueError: the mesh must not be written. RuntimeError: a task uses it.
    """
    meshes.check_mesh(obj)
    sessions.check_free(obj)
    shape_keys.check_writable(obj)
    key = pose_key.find(obj)
    if key is not None:
        pose_key.check_name(obj)
        shape_keys.write(obj, key, meshes.read_rest(obj))
    bound = sessions.get(obj.session_uid)
    if bound is not None:
        bound.session.reset()


def apply_pose_as_rest(obj: bpy.types.Object) -> None:
    """Makes the pose the new rest shape. Basis takes it, other keys keep their offsets, the handles are at rest here.

    Stored poses take the handles to the same places as before.

    Raises:
        ValueError: there is no pose, the pose key does not show it, or the mesh or an attached object is not
            writable.
        RuntimeError: a task uses the mesh.
    """
    key = _pose_key(obj)
    sessions.check_free(obj)
    shape_keys.check_shown(obj, key)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    meshes.read_stretch(obj, depsgraph)  # raises before anything has changed
    shape_keys.shift_all(obj, key, pose_key.shown_positions(obj, meshes.read_rest(obj)))
    rests = _rest_matrices(obj)
    _set_rest_here(obj, depsgraph)
    placing.forget_bases(obj)
    _follow_new_rest(obj, rests)
    sessions.drop(obj.session_uid)


def _set_rest_here(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
    """Makes every handle's present place its place at rest."""
    inverse = inverted(handle_motion.object_matrix(obj, depsgraph))
    for handle in obj.arap.handles:
        if handle_motion.problem_of(obj, handle, depsgraph):
            continue
        handle.rest = Matrix(inverse @ handle_motion.target_matrix(handle.target, handle.bone, depsgraph))


def _follow_new_rest(obj: bpy.types.Object, former: dict[int, Floats]) -> None:
    """Lets stored poses put the handles to the same places as before, now that these are at rest elsewhere.

    Args:
        obj: the mesh, with its new rest matrices.
        former: (4, 4) rest matrices before, by the handles' numbers.
    """
    moved = {
        handle.pose_id: former[handle.pose_id] @ inverted(np.array(handle.rest, dtype=np.float64))
        for handle in obj.arap.handles
        if handle.pose_id in former and abs(handle.rest.determinant()) >= handle_motion.SMALLEST_VOLUME
    }
    for pose in obj.arap.poses:
        for item in pose.motions:
            if item.handle_id in moved:
                motion = np.array(item.motion, dtype=np.float64).reshape(4, 4) @ moved[item.handle_id]
                item.motion = motion.ravel().tolist()


def _rest_matrices(obj: bpy.types.Object) -> dict[int, Floats]:
    """(4, 4) rest matrices of the handles that a pose may know, by their numbers."""
    return {h.pose_id: np.array(h.rest, dtype=np.float64) for h in obj.arap.handles if h.pose_id}


def capture_state(obj: bpy.types.Object) -> PoseState:
    """The state that restore_state() restores."""
    key, transforms, bases = pose_key.capture(obj), capture_transforms(obj), preserve_shape.capture_bases(obj)
    return PoseState(known.add(obj), key, transforms, bases)


def restore_state(obj: bpy.types.Object, state: PoseState) -> None:
    """Restores the handles, what pins and handles hold, the pose key with its slider, and the session.

    Skips objects and bones that are gone. Pins and handles that are new since then hold the mesh as it is shown now.

    Raises:
        ValueError: the mesh has another number of vertices; then only pins and handles go back.
        RuntimeError: a task uses the mesh; then nothing goes back.
    """
    sessions.check_free(obj)
    restore_transforms(state.transforms)
    added = preserve_shape.restore_bases(obj, state.bases)
    pose_key.restore(obj, state.key)
    bound = sessions.get(obj.session_uid)
    if bound is not None:
        if state.key.positions is None:
            bound.session.reset()
        else:
            bound.session.set_positions(state.key.positions)
    if added:
        rebase(obj, *added)


def capture_transforms(obj: bpy.types.Object) -> Transforms:
    """Channels of the objects that move handles, see chain.transform_sources(), and of all bones of armatures."""
    return {place: _channels(item) for place, item in _movers(obj)}


def restore_transforms(transforms: Transforms) -> None:
    """Restores what capture_transforms() returned. Skips objects and bones that are gone."""
    for (uid, bone), channels in transforms.items():
        item = _item_at(uid, bone)
        if item is not None:
            _set_channels(item, channels)


def _pose_key(obj: bpy.types.Object) -> bpy.types.ShapeKey:
    meshes.check_mesh(obj)
    shape_keys.check_writable(obj)
    pose_key.check_name(obj)
    key = pose_key.find(obj)
    if key is None:
        raise ValueError(f"'{obj.name}' has no pose yet: pose it first")
    return key


def _movers(obj: bpy.types.Object) -> Iterator[tuple[tuple[int, str], Any]]:
    """The objects and bones that move a handle, with all bones of an armature."""
    for item in chain.transform_sources(obj, obj.arap.controls):
        uid = known.add(item)
        yield (uid, ""), item
        for bone in item.pose.bones if item.pose else ():
            yield (uid, bone.name), bone


def _item_at(uid: int, bone: str) -> Any:
    item = known.find(uid)
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
