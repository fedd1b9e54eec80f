# SPDX-License-Identifier: GPL-3.0-or-later
"""What the posing act needs of Blender while a piece of the surface is pulled: its PoseScene."""

from __future__ import annotations

from collections.abc import Sequence

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import sessions
from ..core.arrays import Floats
from ..core.session_data import Readout
from ..follow.bind import SessionBinding
from ..follow.frame import Frame
from ..follow.scene import BlenderFollowScene
from ..pose.result import capture_state
from ..scene import meshes, pose_key
from . import hold
from .region import Grab


class PullScene(BlenderFollowScene):
    """The PoseScene of one drag."""

    initial_guess = "previous"

    def __init__(self, obj: bpy.types.Object, grabs: Sequence[Grab]) -> None:
        """Begins. Raises ValueError where the mesh cannot be pulled there; then nothing has changed."""
        super().__init__(obj)
        pose_key.forget_removed(obj)
        self.state = capture_state(obj)
        self.motion: Floats = np.eye(4)
        self.pull = hold.begin_pull(obj, bpy.context.evaluated_depsgraph_get(), grabs)
        self._world = meshes.read_matrix(obj, bpy.context.evaluated_depsgraph_get())
        self._counts = len(obj.data.vertices), len(obj.data.polygons)
        self._start: NDArray[np.float32] | None = self.pull.shown  # whatever the value of the key is
        self._binding: SessionBinding | None = None

    def grab(self, grabs: Sequence[Grab]) -> None:
        """Takes hold of another piece around the same place; what was begun goes on with it."""
        obj = self._obj()
        self.pull = hold.begin_pull(obj, bpy.context.evaluated_depsgraph_get(), grabs, self.pull)
        self._binding = None

    def why_over(self) -> str:
        obj = self.obj
        if obj is None or obj.name not in bpy.context.scene.objects:
            return f"'{self.name}' was deleted or renamed: the pull has ended"
        if obj.mode != "OBJECT":
            return f"'{self.name}' is no longer in Object Mode: the pull has ended"
        if (len(obj.data.vertices), len(obj.data.polygons)) != self._counts:
            return f"The mesh of '{self.name}' has changed: the pull has ended"
        return ""

    def is_bound(self) -> bool:
        bound = sessions.get(self.name)
        if bound is None or self._binding is None or bound.session is not self._binding.result():
            return False
        self._frame = Frame(self._obj(), bpy.context.evaluated_depsgraph_get(), holds=self.pull.holds)
        return not self._frame.problem

    def begin_bind(self) -> SessionBinding:
        self._binding = SessionBinding(self._obj(), self.pull.inputs, self._start)
        return self._binding

    def update(self, matrices: Floats, iterations: int | None, time_limit_s: float | None) -> Readout:
        readout = super().update(matrices, iterations, time_limit_s)
        self._start = None  # from here on the key shows where the drag is
        return readout

    def matrices(self) -> NDArray[np.float64]:
        return self.pull.matrices(self.motion, self._world)
