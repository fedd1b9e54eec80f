# SPDX-License-Identifier: GPL-3.0-or-later
"""A walk over the frames of a scene, once for all meshes: what moves them is noted, and solved later.

To change the frame evaluates the whole scene. So several meshes share a walk, and no frame is solved before all are
read: a handle that breaks in the last frame is told before the work.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import bpy

from ..core import naming
from ..core.arrays import Floats
from ..core.mirror import Mirror
from ..scene import handle_motion, known, meshes
from . import frame_state
from .former_bakes import FormerBakes
from .shapes_job import depsgraph_of


@dataclass(frozen=True)
class FrameMotion:
    """What a frame means for a mesh: its stretch, the planes of its Mirror modifier, and motions of its handles."""

    stretch: Floats
    mirrors: tuple[Mirror, ...]
    matrices: Floats


class FramesWalk:
    """Reads frames for the meshes that join, in steps. Holds no Blender data.

    It changes the current frame while it reads, and meanwhile the F-curves of the meshes' former bakes are muted: they
    are evaluated for nothing. When the last mesh leaves, all animated values are as before.
    """

    def __init__(self, scene: bpy.types.Scene, frames: Sequence[int]) -> None:
        self.frames = list(frames)
        self._scene_uid: int = scene.session_uid
        self._frame_before = (scene.frame_current, scene.frame_subframe)
        self._values_before = frame_state.capture()
        self._motions: dict[int, list[FrameMotion]] = {}  # by uid of the mesh
        self._rests: dict[int, Floats] = {}
        self._former: FormerBakes | None = None
        self._n_read = 0

    @property
    def is_done(self) -> bool:
        return self._n_read == len(self.frames)

    @property
    def frame(self) -> int:
        """The frame that is read next."""
        return self.frames[min(self._n_read, len(self.frames) - 1)]

    @property
    def fraction(self) -> float:
        return self._n_read / len(self.frames)

    def join(self, obj: bpy.types.Object, rest: Floats) -> None:
        """Reads for this mesh, too. Before the first step. ``rest``: (n, 3)."""
        uid = known.add(obj)
        self._motions[uid], self._rests[uid] = [], rest

    def motion(self, uid: int, index: int) -> FrameMotion:
        """Of a frame, once all are read."""
        return self._motions[uid][index]

    def forget_values(self, data: bpy.types.ID, data_paths: set[str]) -> None:
        """These are written by the work: they will not be as before."""
        frame_state.drop(self._values_before, data, data_paths)

    def step(self, time_limit_s: float) -> None:
        """Reads for about ``time_limit_s``.

        Raises:
            ValueError: a handle cannot work in a frame, or a mesh is scaled to nothing there.
        """
        scene, end = known.find_scene(self._scene_uid), time.monotonic() + time_limit_s
        assert scene is not None  # the job of each mesh has looked
        if self._former is None:
            self._former = FormerBakes([obj for obj in map(known.find, self._motions) if obj is not None])
        while True:
            scene.frame_set(self.frame)
            self._read(depsgraph_of(scene))
            if self.is_done:
                self._go_back()
            if self.is_done or time.monotonic() >= end:
                return

    def leave(self, uid: int) -> None:
        """The work on this mesh has ended. Does nothing if it has left."""
        if self._motions.pop(uid, None) is not None and not self._motions:
            self._go_back()
        self._rests.pop(uid, None)

    def _read(self, depsgraph: bpy.types.Depsgraph) -> None:
        problems = []
        for uid, motions in self._motions.items():
            obj = known.find(uid)
            assert obj is not None  # the job of each mesh has looked
            try:
                motions.append(self._motion_now(obj, depsgraph))
            except ValueError as error:
                problems.append(str(error))
        if problems:
            raise ValueError(naming.sentences(problems))
        self._n_read += 1

    def _motion_now(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> FrameMotion:
        stretch = meshes.read_stretch(obj, depsgraph)
        mirrors = meshes.read_mirrors(obj, depsgraph, stretch, self._rests[obj.session_uid])
        return FrameMotion(stretch, mirrors, handle_motion.handle_matrices(obj, depsgraph))

    def _go_back(self) -> None:
        if self._former is not None:
            self._former.wake()
        scene = known.find_scene(self._scene_uid)
        if scene is not None:
            frame, subframe = self._frame_before
            scene.frame_set(frame, subframe=subframe)
            frame_state.restore(self._values_before)
