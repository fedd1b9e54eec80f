# SPDX-License-Identifier: GPL-3.0-or-later
"""Solving frame after frame of a scene, for a bake or an export."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import bpy

from ..core.mirror import are_same
from ..core.session_input import is_same_stretch
from ..scene.movers import still
from .shapes_job import Result, ShapesJob
from .walk import FramesWalk


class FramesJob(ShapesJob[Result]):
    """A ShapesJob of frames: the first frame starts from rest, every other one from the frame before.

    First all frames are read: see FramesWalk.
    """

    def __init__(
        self, obj: bpy.types.Object, scene: bpy.types.Scene, frames: Sequence[int], walk: FramesWalk | None
    ) -> None:
        """``walk``: over the same frames of the scene, for several jobs; None: one of its own."""
        self._frames = list(frames)
        self._walk = walk or FramesWalk(scene, frames)
        super().__init__(obj, scene, len(self._frames))
        self._walk.join(obj, self._inputs.mesh.rest_positions)

    @property
    def frame(self) -> int:
        """The frame that is solved now."""
        return self._frames[min(self._n_done, self.n_shapes - 1)]

    @property
    def status(self) -> str:
        return super().status if self._walk.is_done else f"reading frame {self._walk.frame}, {self._walk.fraction:.0%}"

    @property
    def stage_fraction(self) -> float:
        return super().stage_fraction if self._walk.is_done else self._walk.fraction

    def _check_ready(self, obj: bpy.types.Object, _depsgraph: bpy.types.Depsgraph) -> None:
        still.check(obj)

    def _shape_name(self) -> str:
        return f"frame {self.frame}"

    def _work(self, time_limit_s: float) -> None:
        self._scene()
        self._object()
        if self._walk.is_done:
            super()._work(time_limit_s)
        else:
            self._walk.step(time_limit_s)

    def _begin_shape(self) -> None:
        assert self._session is not None
        now = self._walk.motion(self.uid, self._n_done)
        if is_same_stretch(self._session.stretch, now.stretch) and are_same(self._session.mirrors, now.mirrors):
            self._matrices = now.matrices
        else:
            # The scale or a mirror plane is animated: what looks rigid, and what is posed, depends on them.
            self._begin_bind(replace(self._inputs, stretch=now.stretch, mirrors=now.mirrors))

    def _is_from_rest(self) -> bool:
        return self._n_done == 0

    def _go_back(self) -> None:
        self._walk.leave(self.uid)
        super()._go_back()
