# SPDX-License-Identifier: GPL-3.0-or-later
"""Baking an animation of the handles to keyframed shape keys."""

from __future__ import annotations

import re
from dataclasses import dataclass

import bpy

from ..core.arrays import Float32s
from ..core.job import run_job
from ..core.models import Progress
from ..core.naming import NAME_BYTES
from ..core.patches import surface_diagonal
from ..scene import frame_state, meshes, pose_key, shape_keys
from .fewest_keys import KeySearch
from .frames_job import FramesJob, check_range
from .shapes_job import check_in_scene
from .store import ShapeStore

IN_THE_TAB = "in the tab: another name in Settings > Shape Key"
BYTES_PER_VERTEX = 12  # of a shape key, and of a frame of a cache


@dataclass(frozen=True)
class BakeEstimate:
    """What a bake would make at most. In memory keys are held twice: the data, and Blender's evaluated copy."""

    n_keys: int
    n_vertices: int

    @property
    def bytes_in_file(self) -> int:
        return self.n_keys * self.n_vertices * BYTES_PER_VERTEX

    @property
    def bytes_in_memory(self) -> int:
        return 2 * self.bytes_in_file

    def __str__(self) -> str:
        """'48 keys, 7 MB in the file, 14 MB in memory'."""
        sizes = size_text(self.bytes_in_file), size_text(self.bytes_in_memory)
        return "{}, {} in the file, {} in memory".format(_keys_text(self.n_keys), *sizes)


@dataclass(frozen=True)
class Fit:
    """How well the keys of a bake stand for its frames.

    Attributes:
        n_frames: that were solved.
        n_keys: that were made of them.
        largest_distance: of any vertex in any of these frames from where the keys show it, in world units.
        size: the diagonal of the mesh's box at rest, in world units.
    """

    n_frames: int
    n_keys: int
    largest_distance: float
    size: float

    def __str__(self) -> str:
        """'9 keys for 48 frames, off by 0.080 % of the size at most'; '48 keys' where no frame was left out."""
        if self.n_keys == self.n_frames:
            return _keys_text(self.n_keys)
        percent = 100.0 * self.largest_distance / self.size if self.size else 0.0
        return f"{self.n_keys} keys for {self.n_frames} frames, off by {percent:.3f} % of the size at most"


class BakeJob(FramesJob[list[str]]):
    """Bakes frames to shape keys; see begin_bake(). finish() returns the keys' names."""

    noun = "bake"
    doing = "it is baked"

    def __init__(
        self,
        obj: bpy.types.Object,
        scene: bpy.types.Scene,
        frames: list[int],
        prefix: str,
        tolerance_percent: float | None,
    ) -> None:
        self._prefix = prefix
        self._tolerance_percent = tolerance_percent
        self._shapes = ShapeStore(len(obj.data.vertices))
        self._search: KeySearch | None = None
        super().__init__(obj, scene, frames)
        mesh = self._inputs.mesh
        self._size = surface_diagonal(mesh.rest_positions @ self._inputs.stretch.T, mesh.corner_vertices)

    @property
    def fit(self) -> Fit:
        """How well the keys stand for the frames; once step() has returned False."""
        n = len(self._frames)
        if self._search is None:
            return Fit(n, n, 0.0, self._size)
        return Fit(n, len(self._search.keys), self._search.largest_distance, self._size)

    @property
    def status(self) -> str:
        if self._search is not None:
            return "all frames are solved, choosing the fewest keys"
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
            obj, self._prefix, [self._frames[i] for i in kept], (self._shapes[i] for i in kept)
        )
        self._shapes.close()
        pose_key.keep_name(obj)  # the next bake is to replace this one
        key = pose_key.find(obj)
        if key is not None:
            key.mute = True  # or its pose would be added to every baked one
        # A key of the former bake may have had the name of a new one.
        keys = obj.data.shape_keys
        frame_state.drop(self._values_before, keys, {shape_keys.value_path(keys.key_blocks[name]) for name in names})
        return names


def estimate_bake(obj: bpy.types.Object, start: int, end: int, step: int = 1) -> BakeEstimate:
    """How many keys and bytes bake_animation() of the same arguments would make at most."""
    meshes.check_mesh(obj)
    return BakeEstimate(len(frames_of(start, end, step)), len(obj.data.vertices))


def begin_bake(
    obj: bpy.types.Object,
    start: int,
    end: int,
    step: int = 1,
    prefix: str = "",
    scene: bpy.types.Scene | None = None,
    *,
    fewest_keys_percent: float | None = None,
) -> BakeJob:
    """Checks everything and returns the job, which begins to bind where needed. Arguments as bake_animation()."""
    scene = scene or bpy.context.scene
    frames = frames_of(start, end, step)
    check_in_scene(obj, scene)
    if fewest_keys_percent is not None and not 0.0 <= fewest_keys_percent <= 100.0:
        raise ValueError(f"fewest_keys_percent = {fewest_keys_percent}, must be between 0 and 100")
    prefix = prefix or f"{pose_key.wanted_name(obj)}_"
    meshes.check_mesh(obj)
    _check_prefix(obj, prefix, frames)
    shape_keys.check_animatable(obj)
    return BakeJob(obj, scene, frames, prefix, fewest_keys_percent)


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
    """Bakes frames start, start + step, ... and end to one shape key each, or to as few as do.

    At each key's frame exactly that frame's pose shows; in between neighbours blend linearly. Keys of an earlier
    bake with the same prefix are replaced. The live key is muted so that it does not add to them.

    Args:
        obj: the mesh.
        start: first frame.
        end: last frame, always baked.
        step: frames from one solved frame to the next.
        progress: see the module's text.
        prefix: keys are named prefix + frame; '' takes the live key's name and '_'.
        scene: whose frames; None takes the current scene.
        fewest_keys_percent: None: a key for each solved frame. Else only the fewest that keep every vertex of every
            solved frame within this distance of where the blend shows it, in percent of the mesh's size (the diagonal
            of its box at rest), as seen under the object's scale.

    Returns:
        The names of the keys.

    Raises:
        ValueError: end before start, step below 1, absolute keys, linked or shared mesh data, and as solve() does.
        RuntimeError: the disk is full: what does not fit into memory waits in a temporary file.
        Cancelled: ``progress`` returned False; nothing has changed.
    """
    job = begin_bake(obj, start, end, step, prefix, scene, fewest_keys_percent=fewest_keys_percent)
    return run_job(job, progress)


def frames_of(start: int, end: int, step: int) -> list[int]:
    """The frames that a bake solves. Raises ValueError."""
    check_range(start, end, step)
    return [*range(start, end, step), end]


def _keys_text(n_keys: int) -> str:
    return "1 key" if n_keys == 1 else f"{n_keys} keys"


def size_text(n_bytes: float) -> str:
    """'7 MB'."""
    for unit in ("B", "kB", "MB"):
        if n_bytes < 1000:
            return f"{n_bytes:.0f} {unit}"
        n_bytes = n_bytes / 1000
    return f"{n_bytes:.1f} GB"


def _check_prefix(obj: bpy.types.Object, prefix: str, frames: list[int]) -> None:
    if any(len(shape_keys.frame_key_name(prefix, frame).encode()) > NAME_BYTES for frame in frames):
        raise ValueError(
            f"Prefix '{prefix}' is too long for the names of shape keys: take a shorter one ({IN_THE_TAB})"
        )
    taken = {pose_key.wanted_name(obj)}
    if obj.data.shape_keys is not None:
        taken.add(obj.data.shape_keys.reference_key.name)
    for name in taken:
        if re.fullmatch(re.escape(prefix) + shape_keys.FRAME_PATTERN, name):
            raise ValueError(
                f"A bake with prefix '{prefix}' would replace shape key '{name}': take another prefix ({IN_THE_TAB})"
            )
    baked = set(shape_keys.frame_keys(obj, prefix))
    for frame in frames:
        name = shape_keys.frame_key_name(prefix, frame)
        if name not in baked and shape_keys.find(obj, name) is not None:
            raise ValueError(
                f"There is a shape key '{name}' that no bake has made: rename it, or take another prefix ({IN_THE_TAB})"
            )
