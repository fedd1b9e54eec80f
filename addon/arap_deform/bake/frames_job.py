# SPDX-License-Identifier: GPL-3.0-or-later
"""Solving frame after frame of a scene, for a bake or an export."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import bpy

from ..core.mirror import are_same
from ..core.session_input import is_same_stretch
from ..scene import frame_state, handle_motion, meshes
from .shapes_job import Result, ShapesJob, depsgraph_of


class FramesJob(ShapesJob[Result]):
    """A ShapesJob of frames: the first frame starts from rest, every other one from the frame before.

    It changes the current frame until its end.
    """

    def __init__(self, obj: bpy.types.Object, scene: bpy.types.Scene, frames: Sequence[int]) -> None:
        self._frames = list(frames)
        self._frame_before = (scene.frame_current, scene.frame_subframe)
        self._values_before = frame_state.capture()
        super().__init__(obj, scene, len(self._frames))

    @property
    def frame(self) -> int:
        """The frame that is solved now."""
        return self._frames[min(self._n_done, self.n_shapes - 1)]

    def _shape_name(self) -> str:
        return f"frame {self.frame}"

    def _begin_shape(self) -> None:
        assert self._session is not None
        scene = self._scene()
        scene.frame_set(self.frame)
        obj = self._object()
        depsgraph = depsgraph_of(scene)
        stretch = meshes.read_stretch(obj, depsgraph)
        mirrors = meshes.read_mirrors(obj, depsgraph, stretch, self._inputs.mesh.rest_positions)
        if not (is_same_stretch(self._session.stretch, stretch) and are_same(self._session.mirrors, mirrors)):
            # The scale or a mirror plane is animated: what looks rigid, and what is posed, depends on them.
            self._begin_bind(replace(self._inputs, stretch=stretch, mirrors=mirrors))
        else:
            self._matrices = handle_motion.handle_matrices(obj, depsgraph)

    def _is_from_rest(self) -> bool:
        return self._n_done == 0

    def _go_back(self) -> None:
        scene = bpy.data.scenes.get(self._scene_name)
        if scene is not None:
            frame, subframe = self._frame_before
            scene.frame_set(frame, subframe=subframe)
            frame_state.restore(self._values_before)
        super()._go_back()
