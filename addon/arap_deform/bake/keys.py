# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking an animation of the handles to keyframed shape keys."""

from __future__ import annotations

import re

import bpy

from ..core.arrays import Float32s
from ..core.background import Progress
from ..core.job import run_job
from ..core.mirror import seen_size
from ..core.naming import NAME_BYTES
from ..engine import ready
from ..scene import baked, fcurves, pose_key, shape_keys
from .estimate import BakeEstimate, Fit, check_search, frames_of
from .fewest_keys import KeySearch
from .frames_job import FramesJob
from .shapes_job import check_in_scene
from .store import ShapeStore
from .walk import FramesWalk

IN_THE_TAB = "in the tab: Advanced > Shape Key"


class BakeJob(FramesJob[list[str]]):
    """Bakes frames to shape keys, in steps; see bake_animation(). finish() returns the names of the keys."""

    noun = "bake"
    doing = "it is baked"

    def __init__(
        self,
        obj: bpy.types.Object,
        start: int,
        end: int,
        step: int = 1,
        prefix: str = "",
        scene: bpy.types.Scene | None = None,
        *,
        fewest_keys_percent: float | None = None,
        walk: FramesWalk | None = None,
    ) -> None:
        """Checks everything. Arguments and errors as bake_animation(); ``walk``: see FramesJob."""
        scene = scene or bpy.context.scene
        frames = frames_of(start, end, step)
        check_in_scene(obj, scene)
        if fewest_keys_percent is not None and not 0.0 <= fewest_keys_percent <= 100.0:
            raise ValueError(f"fewest_keys_percent = {fewest_keys_percent}, must be between 0 and 100")
        if fewest_keys_percent is not None:
            check_search(len(frames))
        self._prefix = prefix or f"{pose_key.wanted_name(obj)}_"
        _check_prefix(obj, self._prefix, frames)
        shape_keys.check_animatable(obj)
        self._tolerance_percent = fewest_keys_percent
        self._shapes = ShapeStore(len(obj.data.vertices), len(frames))
        self._search: KeySearch | None = None
        super().__init__(obj, scene, frames, walk)
        self._size = seen_size(self._inputs.mesh, self._inputs.mirrors, self._inputs.stretch)

    def _check_ready(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        shape_keys.check_none_alone(obj, None)
        ready.check(obj, depsgraph, self._inputs)
        ready.check_rendered(obj, depsgraph, self._inputs)

    @property
    def fit(self) -> Fit:
        """How well the keys fit the frames; after step() has returned False."""
        n = len(self._frames)
        if self._search is None:
            return Fit(n, n, 0.0, self._size)
        return Fit(n, len(self._search.keys), self._search.largest_distance, self._size)

    @property
    def bytes_in_file(self) -> int:
        """What the keys take at least."""
        n_keys = self.n_shapes if self._tolerance_percent is None else 1
        return BakeEstimate(n_keys, self._inputs.counts[0]).bytes_in_file

    @property
    def status(self) -> str:
        if self._search is not None:
            return "all frames are solved, searching the fewest keys"
        return super().status

    def cancel(self) -> None:
        super().cancel()
        self._shapes.close()

    def _take(self, shape: Float32s) -> None:
        self._shapes.append(shape)

    def _conclude(self, time_limit_s: float) -> bool:
        if self._tolerance_percent is None:
            return False
        if self._search is None:
            tolerance = self._tolerance_percent / 100.0 * self._size
            times = [float(frame) for frame in self._frames]
            self._search = KeySearch(self._shapes, times, tolerance, self._inputs.stretch)
        return self._search.step(time_limit_s)

    def _write(self, obj: bpy.types.Object) -> list[str]:
        shape_keys.check_writable(obj)
        kept = range(len(self._frames)) if self._search is None else self._search.keys
        names = shape_keys.write_animation(
            obj,
            self._prefix,
            [self._frames[i] for i in kept],
            lambda i: self._shapes[kept[i]],
            fcurves.time_scale(self._scene()),
        )
        self._shapes.close()
        baked.show(obj, self._prefix)
        pose_key.keep_name(obj)  # so that the next bake replaces this one
        key = pose_key.find(obj)
        if key is not None:
            key.mute = True  # else its pose would add to every baked pose
        # A key of the former bake may have the name of a new one.
        keys = obj.data.shape_keys
        self._walk.forget_values(keys, {shape_keys.value_path(keys.key_blocks[name]) for name in names})
        return names


def bake_animation(
    obj: bpy.types.Object,
    start: int,
    end: int,
    step: int = 1,
    progress: Progress | None = None,
    prefix: str = "",
    scene: bpy.types.Scene | None = None,
    *,
    fewest_keys_percent: float | None = None,
) -> list[str]:
    """Bakes frames start, start + step, ... and end to shape keys with keyframes.

    The frame of a key shows exactly its pose; between keys, poses blend linearly. Keys of an earlier bake with the same
    prefix are replaced. Those with another prefix, and the pose key, are muted, so that they do not add to the baked
    keys.

    Args:
        start: first frame.
        end: last frame, always baked.
        step: frames from one solved frame to the next.
        progress: see api.
        prefix: keys are named prefix + frame; '': the pose key's name and '_'.
        scene: the scene with the frames; None: the current scene.
        fewest_keys_percent: None: a key for each solved frame. Else the fewest keys that show every vertex of every
            solved frame within this distance of its place, in percent of the mesh's size (the diagonal of its box at
            rest, under the object's scale).

    Returns:
        The names of the keys.

    Raises:
        ValueError: end before start, step below 1, absolute keys, linked or shared mesh data, and as solve().
        RuntimeError: the disk is full; a long bake needs a temporary file.
        Cancelled: ``progress`` returned False; nothing has changed.
    """
    job = BakeJob(obj, start, end, step, prefix, scene, fewest_keys_percent=fewest_keys_percent)
    return run_job(job, progress)


def _check_prefix(obj: bpy.types.Object, prefix: str, frames: list[int]) -> None:
    if any(len(shape_keys.frame_key_name(prefix, frame).encode()) > NAME_BYTES for frame in frames):
        raise ValueError(
            f"Prefix '{prefix}' is too long for the name of a shape key: choose a shorter one ({IN_THE_TAB})"
        )
    taken = {pose_key.wanted_name(obj)}
    if obj.data.shape_keys is not None:
        taken.add(obj.data.shape_keys.reference_key.name)
    for name in taken:
        if re.fullmatch(re.escape(prefix) + shape_keys.FRAME_PATTERN, name):
            raise ValueError(
                f"A bake with prefix '{prefix}' would replace shape key '{name}': choose another prefix ({IN_THE_TAB})"
            )
    former = set(shape_keys.frame_keys(obj, prefix))
    for frame in frames:
        name = shape_keys.frame_key_name(prefix, frame)
        if name not in former and shape_keys.find(obj, name) is not None:
            raise ValueError(f"No bake has made shape key '{name}': rename it, or choose another prefix ({IN_THE_TAB})")
