# SPDX-License-Identifier: GPL-3.0-or-later
"""What the interaction needs of Blender while a piece of the surface is pulled."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np

from ..core.arrays import Float32s, Floats
from ..core.session_data import SolveStats
from ..engine.mesh import SessionBinding
from ..pose.scene import InteractionScene
from ..scene import meshes
from . import hold
from .drag import Lever
from .region import PulledPatch


class PullScene(InteractionScene):
    """The EngineScene of one drag."""

    task_name = "the pull"
    initial_guess = "previous"

    def __init__(self, obj: bpy.types.Object, grabs: Sequence[PulledPatch]) -> None:
        """Begins. Raises ValueError if the mesh cannot be pulled there; then nothing has changed."""
        super().__init__(obj)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        self.motion: Floats = np.eye(4)
        self.pull = hold.begin_pull(obj, depsgraph, grabs)
        self.constraints = self.pull.holds
        self._world = meshes.read_matrix(obj, depsgraph)
        self._start: Float32s | None = self.pull.shown  # the key alone would not do: its value may not be 1
        self._binding: SessionBinding | None = None

    @property
    def lever(self) -> Lever | None:
        """What the piece under the mouse hangs on; None if it is on no limb."""
        return self.pull.lever(self._world)

    def grab(self, grabs: Sequence[PulledPatch]) -> None:
        """Goes on with the same drag of another piece around the same place."""
        self.pull = hold.begin_pull(self._obj(), bpy.context.evaluated_depsgraph_get(), grabs, self.pull)
        self.constraints = self.pull.holds
        self._binding = None

    def is_bound(self) -> bool:
        if self._bound is None or self._binding is None or self._bound.session is not self._binding.result():
            return False
        return not self._misfit  # what changes meanwhile, the next drag sees

    def begin_bind(self) -> SessionBinding:
        self._binding = SessionBinding(self._obj(), self.pull.inputs, self._start)
        return self._binding

    def update(self, matrices: Floats, iterations: int | None, time_limit_s: float | None) -> SolveStats:
        stats = super().update(matrices, iterations, time_limit_s)
        self._start = None  # the key shows the drag now
        return stats

    def matrices(self) -> Floats:
        return self.pull.matrices(self.motion, self._world)
