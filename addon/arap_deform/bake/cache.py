# SPDX-License-Identifier: GPL-3.0-or-later
"""Exporting an animation of the handles to a point cache, for Blender's Mesh Cache modifier and other programs."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..attach.problems import below
from ..core.arrays import Float32s
from ..core.background import Progress
from ..core.job import run_job
from ..core.naming import listed
from ..engine import ready
from ..scene import fcurves
from .cache_file import CacheWriter, format_of
from .estimate import check_range
from .frames_job import FramesJob
from .shapes_job import check_in_scene

MODIFIER_NAME = "ARAP Cache"


class MeshCacheJob(FramesJob[Path]):
    """Writes frames to a cache, in steps; see export_mesh_cache(). finish() returns the path of the file."""

    noun = "export"
    doing = "its frames are exported"

    def __init__(
        self,
        obj: bpy.types.Object,
        path: str | Path,
        start: int,
        end: int,
        step: int = 1,
        scene: bpy.types.Scene | None = None,
        *,
        add_modifier: bool = False,
    ) -> None:
        """Checks everything. Arguments and errors as export_mesh_cache()."""
        scene = scene or bpy.context.scene
        check_range(start, end, step)
        if add_modifier:
            _check_time(scene, step)
        check_in_scene(obj, scene)
        self._path = whole_path(path)
        format_of(self._path)
        self._step = step
        self._add_modifier = add_modifier
        self._left_out = [attached.name for attached in below(obj)]
        self._writer: CacheWriter | None = None
        super().__init__(obj, scene, list(range(start, end + 1, step)), None)
        fps = scene.render.fps / scene.render.fps_base
        try:
            self._writer = CacheWriter(self._path, len(obj.data.vertices), self._frames, fps)
        except BaseException:
            self.cancel()
            raise

    @property
    def warning(self) -> str:
        left_out = f"What is attached is not in the cache, but in Bake Animation: {listed(self._left_out)}"
        return "; ".join(filter(None, (super().warning, left_out if self._left_out else "")))

    def _check_ready(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        super()._check_ready(obj, depsgraph)
        if self._add_modifier:
            former = {MODIFIER_NAME: False}  # it will play this file
            ready.check_seen(obj, depsgraph, self._inputs, shown=former)

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
            add_mesh_cache_modifier(obj, self._path, self._frames[0], self._step, fcurves.time_scale(self._scene()))
        return self._path


def whole_path(path: str | Path) -> Path:
    """Raises ValueError if it is beside a .blend that is not saved: the working folder would take its place."""
    if str(path).startswith("//") and not bpy.data.filepath:
        raise ValueError(f"{path} is beside the .blend file, which is not saved yet; save it or name a whole path")
    return Path(bpy.path.abspath(str(path)))


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

    The file has the pose in object space, without modifiers, other shape keys and what is attached to the mesh, as the
    Mesh Cache modifier needs it.
    It is written frame by frame, so only the disk limits its length. A complete new file replaces an existing one.

    Args:
        path: ends in .mdd or .pc2; // is the folder of the .blend.
        start: first frame.
        end: last frame, if it is a whole number of steps from the first.
        step: frames from one to the next.
        progress: see api.
        scene: the scene with the frames and the frame rate; None: the current scene.
        add_modifier: gives the object a Mesh Cache modifier, first of all, that plays the file at these frames. A
            modifier of an earlier export is set up again.

    Returns:
        The path.

    Raises:
        ValueError: another suffix, a path that cannot be written, // in a file that is not saved, end before start,
            step below 1, and as solve().
        RuntimeError: the disk is full.
        Cancelled: ``progress`` returned False; nothing has changed, and there is no new file.
    """
    return run_job(MeshCacheJob(obj, path, start, end, step, scene, add_modifier=add_modifier), progress)


def _check_time(scene: bpy.types.Scene, step: int) -> None:
    """Raises ValueError if the modifier cannot play a frame of the file in each ``step`` frames of the scene."""
    fastest = bpy.types.MeshCacheModifier.bl_rna.properties["frame_scale"].hard_max
    if step * fcurves.time_scale(scene) * fastest < 1.0:
        raise ValueError(
            f"Time Stretching of scene '{scene.name}' is more than a Mesh Cache modifier can play: New may be up to "
            f"{step * fastest:.0f} times Old, or export without the modifier"
        )


def add_mesh_cache_modifier(
    obj: bpy.types.Object, path: Path, start: int, step: int, time_scale: float
) -> bpy.types.Modifier:
    """Adds a Mesh Cache modifier, first of all, that shows the first frame of the file at frame ``start``.

    ``time_scale``: see fcurves.time_scale().
    """
    modifier = obj.modifiers.get(MODIFIER_NAME)
    if modifier is None or modifier.type != "MESH_CACHE":
        modifier = obj.modifiers.new(MODIFIER_NAME, "MESH_CACHE")
        obj.modifiers.move(obj.modifiers.find(modifier.name), 0)
    modifier.cache_format = format_of(path)
    modifier.filepath = shown_path(path)
    modifier.interpolation = "LINEAR"
    modifier.deform_mode = "OVERWRITE"
    modifier.play_mode = "SCENE"
    modifier.time_mode = "FRAME"
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"  # Blender's own axes
    modifier.factor = 1.0
    modifier.show_viewport = modifier.show_render = True  # Edit Again may have switched it off
    # The modifier shows frame number frame_scale * time - frame_start of the file.
    modifier.frame_scale = 1.0 / (step * time_scale)
    modifier.frame_start = start / step
    return modifier


def shown_path(path: Path) -> str:
    """The path as Blender saves it: relative to a saved .blend, with // in front, if the preferences say so."""
    path = path.resolve()
    if not bpy.data.filepath or not bpy.context.preferences.filepaths.use_relative_paths:
        return str(path)
    try:
        return str(bpy.path.relpath(str(path)))
    except ValueError:  # another drive
        return str(path)
