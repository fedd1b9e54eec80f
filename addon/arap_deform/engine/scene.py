# SPDX-License-Identifier: GPL-3.0-or-later
"""The EngineScene of an object in Blender. It keeps the uid, no reference: undo replaces all data."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import sessions
from ..core.session_data import SolveStats
from ..core.session_input import Constraint, SessionInput
from ..scene import known, pose_key, redraw, versions
from ..scene.inputs import read_input
from ..scene.snapshot import Snapshot
from . import frame, mesh

# Accuracy of updates with a time limit, as a fraction of the mesh's size. For more the solver goes on in double
# precision and prepares that first: on a large mesh that takes seconds, for a difference that cannot be seen.
ACCURACY = 1e-4


def is_playing() -> bool:
    """Whether a window plays the animation."""
    return any(window.screen.is_animation_playing for window in bpy.context.window_manager.windows)


class BlenderEngineScene:
    """Looks its object up each time."""

    initial_guess: str | None = None  # of update(); None: the object's setting
    key: pose_key.KeyTracker | None = None  # if the key may be renamed while this lasts
    constraints: tuple[Constraint, ...] | None = None  # what the session must hold; None: what the pins and handles do

    def __init__(self, obj: bpy.types.Object) -> None:
        self.uid = known.add(obj)
        self._first_name = obj.name
        self.depsgraph: bpy.types.Depsgraph | None = None
        self._snapshot: Snapshot | None = None  # of this step, from look() on
        self._bound: sessions.Bound | None = None  # then
        self._misfit = ""  # why it does not fit, then
        self._followed: sessions.Bound | None = None  # what the pose was solved with last
        self._has_written = False  # the next change of the mesh is the add-on's own
        self._is_suspect = True  # something else may have changed the mesh
        self._changed_at = 0.0  # when something else changed it last

    @property
    def obj(self) -> bpy.types.Object | None:
        """The object, None if it is gone."""
        return known.find(self.uid)

    @property
    def name(self) -> str:
        """Of the object, for messages."""
        obj = self.obj
        return self._first_name if obj is None else str(obj.name)

    @contextmanager
    def evaluated(self, depsgraph: bpy.types.Depsgraph, updates: Sequence[known.Update] | None) -> Iterator[None]:
        """To be used while a handler runs, which has this depsgraph: Blender evaluates what it writes in silence.

        ``updates``: None for another frame.
        """
        if updates is not None:
            self._note_change(updates)
        before, self.depsgraph = self.depsgraph, depsgraph
        try:
            yield
        finally:
            self.depsgraph = before

    def _note_change(self, updates: Sequence[known.Update]) -> None:
        """Notes whether something else has changed the mesh. A modifier that moves updates the object alone."""
        for update in updates:
            if update.uid == self.uid and update.has_new_data:
                if not self._has_written:
                    self._is_suspect = True
                    self._changed_at = time.monotonic()
                self._has_written = False

    def has_to_wait(self) -> bool:
        if bpy.app.background or not self._is_in_weight_paint():
            return False
        if self.depsgraph is not None:
            return self._is_suspect  # the timer reads the weights: at every step they would make the stroke stutter
        is_painting = versions.is_painting()
        if is_painting:
            self._is_suspect = True
        return is_painting

    def settled(self) -> None:
        # If a stroke began while the mesh still moved, its updates may have looked like the add-on's own.
        if self._is_in_weight_paint():
            self._is_suspect = True

    def _is_in_weight_paint(self) -> bool:
        obj = self._snapshot.obj if self._snapshot is not None else self.obj
        return obj is not None and obj.mode == "WEIGHT_PAINT"

    def look(self) -> str:
        obj = self.obj
        self._snapshot = None
        if reason := self._why_not(obj):
            return reason
        assert obj is not None
        depsgraph = self._depsgraph()  # first: evaluating the scene may make the mesh suspect
        self._bound = sessions.get(self.uid)
        self._snapshot, self._misfit = frame.look(obj, depsgraph, self._bound, self.constraints)
        return ""

    def _why_not(self, obj: bpy.types.Object | None) -> str:
        """What look() returns. ``obj``: None if it is gone."""
        if obj is None:
            raise self._deleted()
        return ""

    def is_bound(self) -> bool:
        now, bound = self._snapshot, self._bound
        if now is None or bound is None or self._misfit:
            return False  # the mesh stays suspect until it is bound
        if self._is_suspect:
            if frame.look_closely(now.obj, now.depsgraph, bound, use_nodes=self._use_nodes):
                return False
            self._is_suspect = False
        return True

    def begin_bind(self) -> mesh.SessionBinding:
        inputs = self._read_inputs()
        self._is_suspect = False  # everything was just read
        return mesh.SessionBinding(self._obj(), inputs)

    def go_on_from_shown(self) -> bool:
        return mesh.sync(self._obj())

    def is_rebound(self) -> bool:
        return sessions.get(self.uid) is not self._followed

    def matrices(self) -> NDArray[np.float64]:
        assert self._snapshot is not None
        return self._snapshot.motions()

    def update(self, matrices: NDArray[np.float64], iterations: int | None, time_limit_s: float | None) -> SolveStats:
        return self._solve(matrices, time_limit_s, iterations=iterations, initial_guess=self.initial_guess)

    def update_from_rest(self, matrices: NDArray[np.float64], time_limit_s: float | None) -> SolveStats:
        return self._solve(matrices, time_limit_s, is_from_rest=True)

    def _solve(self, matrices: NDArray[np.float64], time_limit_s: float | None, **options: Any) -> SolveStats:
        # The next change of the mesh is the add-on's own and must be drawn. look() has evaluated earlier ones.
        self._has_written = self.depsgraph is None
        redraw.tag_meshes()
        options.setdefault("sufficient_accuracy", 0.0 if time_limit_s is None else ACCURACY)
        now, bound = self._snapshot, self._bound
        assert now is not None
        assert bound is not None
        stats = frame.solve(now, bound, matrices, time_limit_s=time_limit_s, **options)
        self._followed = bound
        if now.key.key is None:  # it was made
            self._snapshot = replace(now, key=pose_key.look(now.obj))
            if self.key is not None:
                self.key.note(self._snapshot.key.key)
            self._key_made()
        return stats

    def _key_made(self) -> None:
        """The pose has its key now."""

    @property
    def iteration_limit(self) -> int:
        assert self._snapshot is not None
        return self._snapshot.state.settings.max_iterations

    def _read_inputs(self) -> SessionInput:
        return read_input(self._obj(), self._depsgraph(), use_nodes=self._use_nodes)

    @property
    def _use_nodes(self) -> bool | None:
        """See versions.read_group_weights(). Within a handler nothing may be added to the scene."""
        return None if self.depsgraph is None else False

    def _obj(self) -> bpy.types.Object:
        obj = self.obj
        if obj is None:
            raise self._deleted()
        return obj

    def _deleted(self) -> RuntimeError:
        return RuntimeError(f"'{self.name}' was deleted")

    def _depsgraph(self) -> bpy.types.Depsgraph:
        return self.depsgraph or bpy.context.evaluated_depsgraph_get()


def is_rendering() -> bool:
    """Whether a render runs, or calls this from its own thread: its data must not change."""
    return threading.current_thread() is not threading.main_thread() or bpy.app.is_job_running("RENDER")
