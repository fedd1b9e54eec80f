# SPDX-License-Identifier: GPL-3.0-or-later
"""The FollowScene of an object in Blender. It keeps the uid, no reference: undo replaces all data."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import sessions
from ..core.session_data import Readout
from ..core.session_input import SessionInput
from ..props.bounds import bounded
from ..scene import known, pose_key, redraw, versions
from ..scene.inputs import read_input
from . import mesh
from .frame import Frame

# Accuracy of updates with a time limit, as a fraction of the mesh's size. For more the solver goes on in double
# precision and prepares that first: on a large mesh that takes seconds, for a difference that cannot be seen.
ACCURACY = 1e-4


def is_playing() -> bool:
    """Whether a window plays the animation."""
    return any(window.screen.is_animation_playing for window in bpy.context.window_manager.windows)


class BlenderFollowScene:
    """Looks its object up each time."""

    initial_guess: str | None = None  # of update(); None: the object's setting
    key: pose_key.KeyFollower | None = None  # if the key may be renamed while this lasts

    def __init__(self, obj: bpy.types.Object) -> None:
        self.uid = known.add(obj)
        self._first_name = obj.name
        self.depsgraph: bpy.types.Depsgraph | None = None
        self._frame: Frame | None = None  # of this step, from is_bound() on
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
        if any(update.uid == self.uid and update.has_new_data for update in updates):
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
        obj = self.obj
        return obj is not None and obj.mode == "WEIGHT_PAINT"

    def is_bound(self) -> bool:
        depsgraph = self._depsgraph()  # first: evaluating the scene may make the mesh suspect
        self._frame = Frame(self._obj(), depsgraph, is_thorough=self._is_suspect, use_nodes=self._use_nodes)
        if self._frame.problem:
            return False  # the mesh stays suspect until it is bound
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
        return self._this_frame().matrices()

    def update(self, matrices: NDArray[np.float64], iterations: int | None, time_limit_s: float | None) -> Readout:
        return self._solve(matrices, time_limit_s, iterations=iterations, initial_guess=self.initial_guess)

    def update_from_rest(self, matrices: NDArray[np.float64], time_limit_s: float | None) -> Readout:
        return self._solve(matrices, time_limit_s, is_from_rest=True)

    def _solve(self, matrices: NDArray[np.float64], time_limit_s: float | None, **options: Any) -> Readout:
        # The next change of the mesh is the add-on's own and must be drawn. is_bound() has evaluated earlier ones.
        self._has_written = self.depsgraph is None
        redraw.tag_meshes()
        options.setdefault("sufficient_accuracy", 0.0 if time_limit_s is None else ACCURACY)
        readout = self._this_frame().solve(matrices, time_limit_s=time_limit_s, **options)
        self._followed = sessions.get(self.uid)
        if self.key is not None:
            self.key.note(self._obj())
        return readout

    def iteration_limit(self) -> int:
        return int(bounded(self._obj().arap, "max_iterations"))

    def _read_inputs(self) -> SessionInput:
        return read_input(self._obj(), self._depsgraph(), use_nodes=self._use_nodes)

    @property
    def _use_nodes(self) -> bool | None:
        """See versions.read_group_weights(). Within a handler nothing may be added to the scene."""
        return None if self.depsgraph is None else False

    def _obj(self) -> bpy.types.Object:
        obj = self.obj
        if obj is None:
            raise RuntimeError(f"'{self.name}' was deleted")
        return obj

    def _depsgraph(self) -> bpy.types.Depsgraph:
        return self.depsgraph or bpy.context.evaluated_depsgraph_get()

    def _this_frame(self) -> Frame:
        assert self._frame is not None
        return self._frame


def is_rendering() -> bool:
    """Whether a render runs, or calls this from its own thread: its data must not change."""
    return threading.current_thread() is not threading.main_thread() or bpy.app.is_job_running("RENDER")
