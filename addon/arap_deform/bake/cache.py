# SPDX-License-Identifier: GPL-3.0-or-later
"""Exporting an animation of the handles to a point cache, for Blender's Mesh Cache modifier and other programs."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..core.arrays import Float32s
from ..core.job import run_job
from ..core.models import Progress
from ..scene import meshes, versions
from .cache_file import CacheWriter, format_of
from .frames_job import FramesJob, check_range
from .shapes_job import check_in_scene

MODIFIER_NAME = "ARAP Cache"


class MeshCacheJob(FramesJob[Path]):
    """Writes frames to a cache as they are solved; see begin_mesh_cache(). finish() returns the file's path."""

    noun = "export"
    doing = "its frames are exported"

    def __init__(
        self, obj: bpy.types.Object, scene: bpy.types.Scene, frames: list[int], path: Path, *, add_modifier: bool
    ) -> None:
        self._path = path
        self._add_modifier = add_modifier
        self._writer: CacheWriter | None = None
        super().__init__(obj, scene, frames)
        fps = scene.render.fps / scene.render.fps_base
        self._step = frames[1] - frames[0] if len(frames) > 1 else 1
        try:
            self._writer = CacheWriter(path, len(obj.data.vertices), frames, fps)
        except BaseException:
            self.cancel()
            raise

    def cancel(self) -> None:
        super().cancel()
        if self._writer is not None:
            self._writer.discard()

    def _take(self, shape: Float32s) -> None:
        assert self._writer is not None
        self._writer.append(shape)

    def _write(self, obj: bpy.types.Object) -> Path:
        assert self._writer is not None
        self._writer.finish()
        if self._add_modifier:
            add_mesh_cache_modifier(obj, self._path, self._frames[0], self._step)
        return self._path


def begin_mesh_cache(
    obj: bpy.types.Object,
    path: str | Path,
    start: int,
    end: int,
    step: int = 1,
    scene: bpy.types.Scene | None = None,
    *,
    add_modifier: bool = False,
) -> MeshCacheJob:
    """Checks everything and returns the job, which begins to bind where needed. Arguments as export_mesh_cache()."""
    scene = scene or bpy.context.scene
    check_range(start, end, step)
    check_in_scene(obj, scene)
    meshes.check_mesh(obj)
    path = Path(bpy.path.abspath(str(path)))
    format_of(path)
    return MeshCacheJob(obj, scene, list(range(start, end + 1, step)), path, add_modifier=add_modifier)


def export_mesh_cache(
    obj: bpy.types.Object,
    path: str | Path,
    start: int,
    end: int,
    step: int = 1,
    progress: Progress | None = None,
    scene: bpy.types.Scene | None = None,
    *,
    add_modifier: bool = False,
) -> Path:
    """Solves frames start, start + step, ... up to end as a bake does, and writes them to an MDD or PC2 file.

    The file holds the pose in the object's own space, before modifiers and without other shape keys: what the Mesh
    Cache modifier takes. It is written frame by frame, so its length is limited by the disk alone. An existing file is
    replaced, once the new one is whole.

    Args:
        obj: the mesh.
        path: ends in .mdd or .pc2; // is the folder of the .blend.
        start: first frame.
        end: last frame, where a whole number of steps leads there.
        step: frames from one to the next.
        progress: see the module's text.
        scene: whose frames, and frames a second; None takes the current scene.
        add_modifier: gives the object a Mesh Cache modifier before all others that plays the file at these frames,
            or sets up the one that an earlier export has added.

    Returns:
        The path.

    Raises:
        ValueError: another end of the name, a place that cannot be written, end before start, step below 1, and as
            solve() does.
        RuntimeError: the disk is full.
        Cancelled: ``progress`` returned False; nothing has changed, and there is no new file.
    """
    return run_job(begin_mesh_cache(obj, path, start, end, step, scene, add_modifier=add_modifier), progress)


def add_mesh_cache_modifier(obj: bpy.types.Object, path: Path, start: int, step: int = 1) -> bpy.types.Modifier:
    """A Mesh Cache modifier, first of all, that shows the file's first frame at frame ``start`` of the scene."""
    modifier = obj.modifiers.get(MODIFIER_NAME)
    if modifier is None or modifier.type != "MESH_CACHE":
        modifier = obj.modifiers.new(MODIFIER_NAME, "MESH_CACHE")
        versions.move_modifier_first(obj, modifier)
    modifier.cache_format = format_of(path)
    modifier.filepath = shown_path(path)
    modifier.interpolation = "LINEAR"
    modifier.deform_mode = "OVERWRITE"
    modifier.play_mode = "SCENE"
    modifier.time_mode = "FRAME"
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"  # Blender's own: nothing is turned
    modifier.factor = 1.0
    # It shows frame number frame_scale * frame - frame_start of the file.
    modifier.frame_scale = 1.0 / step
    modifier.frame_start = start / step
    return modifier


def shown_path(path: Path) -> str:
    """As Blender keeps paths: relative to the .blend where that is saved and the preferences want it, // in front."""
    path = path.resolve()
    if not bpy.data.filepath or not bpy.context.preferences.filepaths.use_relative_paths:
        return str(path)
    try:
        return str(bpy.path.relpath(str(path)))
    except ValueError:  # another drive
        return str(path)
