# SPDX-License-Identifier: GPL-3.0-or-later
"""The FollowScene of an object in Blender: when it pauses, and how Follow is switched off."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import native, sessions
from ..core.arrays import Floats
from ..core.session_data import SolveStats
from ..core.session_input import SceneState, difference_of_scene
from ..engine.interaction import print_fault
from ..engine.mesh import SessionBinding
from ..engine.scene import BlenderEngineScene
from ..scene import baked, known, meshes, pose_key, shape_keys, undo_step
from ..scene.console import say
from ..scene.seen import look
from ..scene.snapshot import Snapshot
from .run import NotNow

# A frame that is shown alone is solved to its end. In a window a heavy mesh goes on with it after this time. Without
# one nothing would go on, and a mesh that never settles would hold a script for ever.
FRAME_TIME_LIMIT_S = 10.0
SCRIPT_TIME_LIMIT_S = 60.0

# Single-precision matrices of a mesh that moves as a whole differ by less, relative to the largest entry.
SAME_MOTION = 1e-5

PAUSING_MODES = {"EDIT": "Edit Mode", "SCULPT": "Sculpt Mode"}


@dataclass(frozen=True)
class _Seen:
    """What the pose of a mesh depends on. A reason why there is no pose is told when that changes too."""

    problem: str
    state: SceneState | None = None
    motions: Floats | None = None
    changed_at: float = 0.0

    @classmethod
    def of(cls, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, changed_at: float) -> _Seen:
        """``changed_at``: when the mesh was changed last."""
        try:
            snapshot = Snapshot.read(obj, depsgraph)
            motions = snapshot.motions()
        except ValueError as error:
            return cls(str(error))
        return cls("", snapshot.state, motions, changed_at)

    def is_same_as(self, other: _Seen) -> bool:
        if self.state is None or other.state is None or self.motions is None or other.motions is None:
            return self.problem == other.problem
        return (
            self.changed_at == other.changed_at
            and self.state.settings == other.state.settings
            and not difference_of_scene(self.state, other.state)
            and bool(
                np.all(np.abs(self.motions - other.motions) <= SAME_MOTION * np.abs(other.motions).max(initial=0.0))
            )
        )


class BlenderFollowScene(BlenderEngineScene):
    """Reads from the depsgraph of the handler that runs, or of the window that shows the object."""

    key: pose_key.KeyTracker
    _first: _Seen | None = None
    _has_key = False  # of this step, from look() on
    _lack = ""  # why it cannot follow while weights are painted; the next stroke may change that

    def __init__(self, obj: bpy.types.Object) -> None:
        super().__init__(obj)
        self.key = pose_key.KeyTracker(obj)

    def _why_not(self, obj: bpy.types.Object | None) -> str:
        if obj is None:
            return super()._why_not(obj)
        task = sessions.locked_by(self.uid)
        if task:
            return f"Paused while {task}"
        found = self.key.track(obj)  # in every mode: keys can be renamed in Edit Mode, too. A removed key is made again
        self._has_key = found is not None and found.key is not None
        if self._lack and obj.mode == "WEIGHT_PAINT":
            return self._lack
        if obj.mode in PAUSING_MODES or obj.data.is_editmode:
            return "Paused in {}".format(PAUSING_MODES.get(obj.mode, "Edit Mode"))
        if not meshes.is_evaluated(obj, self._depsgraph()):
            return "Paused: this mesh is disabled, excluded or in another scene"
        if baked.is_shown(obj):
            return "Paused: the bake is shown. Edit Again goes on"
        lack = shape_keys.why_shared(obj)
        return f"Paused: {lack}" if lack else ""

    def has_changed(self) -> bool:
        """What the first call sees is kept. Nothing is seen of an object that Blender does not evaluate."""
        obj, depsgraph = self._obj(), self._depsgraph()
        if not meshes.is_evaluated(obj, depsgraph):
            return False
        now = _Seen.of(obj, depsgraph, self._changed_at)
        if self._first is None:
            self._first = now
        return not now.is_same_as(self._first)

    def _note_change(self, updates: Sequence[known.Update]) -> None:
        super()._note_change(updates)
        self._lack = ""

    def look_again(self) -> None:
        self._is_suspect = True

    def undone(self) -> bool:
        self.key.forget_address()
        self.look_again()
        obj = self.obj
        has_pose = obj is not None and pose_key.find(obj) is not None
        if not has_pose:
            self._first = None
        return has_pose

    def has_to_wait(self) -> bool:
        if bpy.app.background:  # no timer goes on
            return super().has_to_wait()
        is_look_due = self._is_look_due(self._obj())
        return super().has_to_wait() or is_look_due or not self._can_have_key()

    def _is_look_due(self, obj: bpy.types.Object) -> bool:
        """Whether the timer must look first if a pose is seen under these modifiers. Raises NotNow if it is not."""
        if self.depsgraph is None and not look.is_noted(obj):
            look.look(obj, self._depsgraph())
        if reason := look.noted(obj):
            raise NotNow(f"Paused: {reason}")
        return self.depsgraph is not None and not look.is_noted(obj)

    def _can_have_key(self) -> bool:
        """Whether the mesh has its key, or one can be made as a step of undo.

        Undo takes a mesh for the same if no step tells otherwise, and keeps it. So a key that was made between two
        steps would be missing after an undo, but the mesh would still refer to it, and Blender would crash.
        """
        is_timer = self.depsgraph is None
        return self._has_key or (is_timer and undo_step.holds_whole_file())

    def _key_made(self) -> None:
        if not bpy.app.background:
            undo_step.push("ARAP Follow")

    def begin_bind(self) -> SessionBinding:
        try:
            return super().begin_bind()
        except ValueError as error:
            if not self._is_in_weight_paint():
                raise
            self._lack = f"Paused: {error}"
            raise NotNow(self._lack) from None

    def update_from_rest(self, matrices: NDArray[np.float64], time_limit_s: float | None) -> SolveStats:
        if time_limit_s is not None:
            return super().update_from_rest(matrices, time_limit_s)
        if not bpy.app.background:
            return super().update_from_rest(matrices, FRAME_TIME_LIMIT_S)
        stats = self._solve(matrices, SCRIPT_TIME_LIMIT_S, is_from_rest=True, sufficient_accuracy=0.0)
        if stats.stop_reason == "time_limit":
            raise RuntimeError(
                f"'{self.name}' has not settled within {SCRIPT_TIME_LIMIT_S:g} seconds (raise Accuracy in Advanced)"
            )
        return stats

    def switch_off(self, error: Exception) -> None:
        print_fault(error)
        obj = self.obj
        if obj is not None:
            obj.arap.use_follow = False
            obj.arap.follow_error = f"{native.sentence_of(error)}: Follow is off"
            if bpy.app.background:
                say(f"ARAP: {obj.arap.follow_error}")

    def _depsgraph(self) -> bpy.types.Depsgraph:
        if self.depsgraph is not None:
            return self.depsgraph
        for window in bpy.context.window_manager.windows:
            if window.scene != bpy.context.scene and known.is_in(window.view_layer, self.obj):
                window.view_layer.update()
                return window.view_layer.depsgraph
        return super()._depsgraph()
