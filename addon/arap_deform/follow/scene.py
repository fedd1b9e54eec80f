# SPDX-License-Identifier: GPL-3.0-or-later
"""The FollowScene of an object in Blender: names instead of references, for undo replaces all data."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core.session_data import Readout
from ..core.sessions import SessionInput
from ..scene import redraw, versions
from ..scene.handle_motion import handle_matrices
from . import mesh
from .bind import SessionBinding
from .update import session_input

# A stroke of a brush tags the mesh at every step. Where Blender does not say whether one is under way, it has ended
# once there was none for this time.
STROKE_PAUSE_S = 0.15
# Of updates that somebody waits for, as a fraction of the mesh's size. Nearer, the solver goes on in double precision,
# and makes what that needs first: on a large mesh that takes seconds, and nobody sees the difference.
ACCURACY = 1e-4


def _sufficient(time_limit_s: float | None) -> float:
    return 0.0 if time_limit_s is None else ACCURACY


class BlenderFollowScene:
    """Looks its object up by name each time."""

    initial_guess: str | None = None  # of update(); None: the object's setting

    def __init__(self, obj: bpy.types.Object) -> None:
        self.name = obj.name
        self.depsgraph: bpy.types.Depsgraph | None = None
        self._has_written = False  # what is evaluated next is of our own making
        self._is_suspect = True  # somebody else may have changed the mesh
        self._changed_at = -STROKE_PAUSE_S  # when somebody did so last

    @property
    def obj(self) -> bpy.types.Object | None:
        """The object, None where it is gone."""
        return bpy.data.objects.get((self.name, None))

    @contextmanager
    def evaluated(self, depsgraph: bpy.types.Depsgraph, *, is_frame: bool) -> Iterator[None]:
        """While a handler runs: what was evaluated, because of an update or for another frame.

        What a handler writes is evaluated without another call of a handler, in both cases.
        """
        if not is_frame:
            self._note_change(depsgraph)
        before, self.depsgraph = self.depsgraph, depsgraph
        try:
            yield
        finally:
            self.depsgraph = before

    def _note_change(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Looks whether somebody else has changed the mesh; a modifier that moves updates the object alone."""
        obj = self.obj
        for update in depsgraph.updates:
            if update.is_updated_geometry and obj is not None and update.id.original == obj.data:
                if not self._has_written:
                    self._is_suspect = True
                    self._changed_at = time.monotonic()
                self._has_written = False

    def has_to_wait(self) -> bool:
        if bpy.app.background or not self._is_in_weight_paint():
            return False
        if self.depsgraph is not None:
            return self._is_suspect  # the timer looks: reading weights at every step of a stroke would make it stutter
        is_painting = versions.is_painting()
        if is_painting:
            self._is_suspect = True
        if is_painting is None:
            return self._is_suspect and time.monotonic() - self._changed_at < STROKE_PAUSE_S
        return is_painting

    def settled(self) -> None:
        # A stroke that began while the mesh still moved may have shown up in no update but those of our own writes.
        if self._is_in_weight_paint():
            self._is_suspect = True

    def _is_in_weight_paint(self) -> bool:
        obj = self.obj
        return obj is not None and obj.mode == "WEIGHT_PAINT"

    def is_bound(self) -> bool:
        use_nodes = None if self.depsgraph is None else False  # within a handler nothing may be added to the scene
        depsgraph = self._depsgraph()  # first: to evaluate the scene may make the mesh suspect
        if mesh.problem(self._obj(), depsgraph, is_thorough=self._is_suspect, use_nodes=use_nodes):
            return False  # and suspect still, until it is bound again
        self._is_suspect = False
        return True

    def begin_bind(self) -> SessionBinding:
        inputs = self._read_inputs()
        self._is_suspect = False  # all is read anew here
        return SessionBinding(self._obj(), inputs)

    def go_on_from_shown(self) -> None:
        mesh.sync(self._obj())

    def matrices(self) -> NDArray[np.float64]:
        return handle_matrices(self._obj(), self._depsgraph())

    def update(self, matrices: NDArray[np.float64], iterations: int | None, time_limit_s: float | None) -> Readout:
        self._announce_write()
        return mesh.update(
            self._obj(),
            matrices,
            iterations=iterations,
            initial_guess=self.initial_guess,
            time_limit_s=time_limit_s,
            sufficient_accuracy=_sufficient(time_limit_s),
        )

    def update_from_rest(self, matrices: NDArray[np.float64], time_limit_s: float | None) -> Readout:
        self._announce_write()
        return mesh.update(
            self._obj(),
            matrices,
            time_limit_s=time_limit_s,
            sufficient_accuracy=_sufficient(time_limit_s),
            is_from_rest=True,
        )

    def iteration_limit(self) -> int:
        return int(self._obj().arap.max_iterations)

    def _read_inputs(self) -> SessionInput:
        return session_input(self._obj(), self._depsgraph())

    def _obj(self) -> bpy.types.Object:
        obj = self.obj
        if obj is None:
            raise RuntimeError(f"'{self.name}' was deleted or renamed")
        return obj

    def _depsgraph(self) -> bpy.types.Depsgraph:
        return self.depsgraph or bpy.context.evaluated_depsgraph_get()

    def _announce_write(self) -> None:
        """The next change of the mesh is ours, and to be drawn."""
        self._depsgraph()  # first: it evaluates the last one, which is somebody else's
        self._has_written = self.depsgraph is None
        redraw.tag_meshes()


def is_rendering() -> bool:
    """Whether this is called for a render, whose data must not change under it: it may be in a thread of its own."""
    return threading.current_thread() is not threading.main_thread() or bpy.app.is_job_running("RENDER")
