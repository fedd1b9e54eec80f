# SPDX-License-Identifier: GPL-3.0-or-later
"""Stored poses -> shape keys: each pose is solved from rest to convergence and written as a key of its name."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ..bake.shapes_job import ShapesJob, check_in_scene
from ..bake.store import ShapeStore
from ..core.arrays import Float32s, Floats
from ..core.background import Progress
from ..core.job import run_job
from ..engine import ready
from ..scene import pose_key, shape_keys, versions
from . import library

if TYPE_CHECKING:
    from ..props.poses import ArapStoredPose


class PoseKeysJob(ShapesJob[list[str]]):
    """Makes shape keys of stored poses, in steps; see poses_to_keys(). finish() returns the names of the keys."""

    noun = "making of shape keys"
    doing = "shape keys are made of its poses"

    def __init__(
        self, obj: bpy.types.Object, names: Sequence[str] | None = None, scene: bpy.types.Scene | None = None
    ) -> None:
        """Checks everything. Arguments and errors as poses_to_keys()."""
        scene = scene or bpy.context.scene
        check_in_scene(obj, scene)
        self._names = [pose.name for pose in obj.arap.poses] if names is None else list(names)
        if not self._names:
            raise ValueError(f"'{obj.name}' has no stored poses: store one first")
        self._pose_matrices = [matrices_of(obj, name) for name in self._names]
        self._shapes = ShapeStore(len(obj.data.vertices), len(self._names))
        super().__init__(obj, scene, len(self._names))

    def cancel(self) -> None:
        super().cancel()
        self._shapes.close()

    def _check_ready(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        ready.check_seen(obj, depsgraph, self._inputs)  # not what moves the handles: the poses say where these are

    def _shape_name(self) -> str:
        return f"pose '{self._names[min(self._n_done, self.n_shapes - 1)]}'"

    def _begin_shape(self) -> None:
        self._object()
        self._matrices = self._pose_matrices[self._n_done]

    def _is_from_rest(self) -> bool:
        return True

    def _take(self, shape: Float32s) -> None:
        self._shapes.append(shape)

    def _write(self, obj: bpy.types.Object) -> list[str]:
        shape_keys.check_writable(obj)
        pose_key.forget_removed(obj)  # else a new key might pass for one that was removed
        poses = [library.find(obj, name) for name in self._names]
        own = [_own_key(obj, pose) for pose in poses]
        # New keys first: if memory runs out for them, they are removed again and nothing has changed.
        new = [i for i, key in enumerate(own) if key is None]
        active = shape_keys.active_name(obj)
        made = dict(
            zip(
                new, shape_keys.add_all(obj, (self._names[i] for i in new), (self._shapes[i] for i in new)), strict=True
            )
        )
        names = []
        for i, pose in enumerate(poses):
            key = shape_keys.find(obj, made[i]) if i in made else own[i]
            assert key is not None
            if i not in made:
                shape_keys.write(obj, key, self._shapes[i])
            if key.name != pose.name:
                key.name = pose.name  # Blender adds a number if another key has the name
            pose.key_name, pose.key_check = key.name, _checksum(key)
            names.append(key.name)
        shape_keys.make_active(obj, active)
        self._shapes.close()
        shape_keys.notify_keys_changed(obj)
        return names


def poses_to_keys(
    obj: bpy.types.Object,
    names: Sequence[str] | None = None,
    progress: Progress | None = None,
    scene: bpy.types.Scene | None = None,
) -> list[str]:
    """Makes a shape key with value 0 and the pose's name of each stored pose. The handles do not move.

    Each pose is solved from rest; handles that it does not have are at rest. A key that an earlier call made of the
    same pose takes the new shape. Other keys stay, also a key that was edited since: then the new name gets a number.

    Args:
        names: of the poses; None: all.
        progress: see api.
        scene: the scene of ``obj``; None: the current one.

    Returns:
        The names of the keys.

    Raises:
        ValueError: no such pose or none at all, linked or shared mesh data, and as solve().
        Cancelled: ``progress`` returned False; nothing has changed.
    """
    return run_job(PoseKeysJob(obj, names, scene), progress)


def matrices_of(obj: bpy.types.Object, name: str) -> Floats:
    """(h, 4, 4) of a stored pose, as handle_motion.handle_matrices(); handles that it does not have are at rest."""
    motions, _ = library.motions_of(obj, name)
    enabled = [i for i, control in enumerate(obj.arap.controls) if control.is_enabled]
    return np.array([motions.get(i, np.eye(4)) for i in enabled]).reshape(-1, 4, 4)


def _own_key(obj: bpy.types.Object, pose: ArapStoredPose) -> bpy.types.ShapeKey | None:
    """The key that was made of the pose; None if there is none, or if it was edited since."""
    key = shape_keys.find(obj, pose.key_name) if pose.key_name else None
    if key is None or key == obj.data.shape_keys.reference_key or _checksum(key) != pose.key_check:
        return None
    return key


def _checksum(key: bpy.types.ShapeKey) -> str:
    return f"{zlib.crc32(versions.read_key(key).tobytes()):08x}"
