# SPDX-License-Identifier: GPL-3.0-or-later
"""Solving several shapes of a mesh, one after the other, in steps: the base of all bakes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from types import GenericAlias
from typing import Any, Generic, TypeVar

import bpy

from ..core import sessions
from ..core.arrays import Float32s, Floats
from ..core.background import Background
from ..core.job import STEP_S
from ..core.session import Session
from ..core.session_data import SolveStats, stats_of_whole
from ..core.session_input import SessionInput
from ..engine import mesh
from ..scene import known, meshes
from ..scene.inputs import read_input

Result = TypeVar("Result")


class ShapesJob(ABC, Generic[Result]):
    """A Job of many solves.

    If no live session fits, the mesh is bound first, in the background, from the first step() on: of many jobs that are
    checked before any work, one is bound at a time. Nothing in the file changes before finish(), except what a kind of
    job says in its own text. If step() or finish() raises, call cancel(): it puts everything back. It holds no
    Blender data.
    """

    __class_getitem__: Any = classmethod(GenericAlias)  # see Background

    noun = "job"  # for messages
    doing: str  # for messages, see sessions.Act

    def __init__(self, obj: bpy.types.Object, scene: bpy.types.Scene, n_shapes: int) -> None:
        """``obj`` is checked. Raises RuntimeError if a task uses it."""
        sessions.check_free(obj)
        self.uid = known.add(obj)
        self.object_name: str = obj.name  # for messages
        self.n_shapes = n_shapes
        self._scene_uid, self._scene_name = scene.session_uid, scene.name
        self._n_done = 0
        self._is_done = False
        self._parts: list[SolveStats] = []  # of the shape being solved
        self._matrices: Floats | None = None
        self._live_session: Session | None = None
        self._has_bound = False  # the live session was made here
        self._live_positions: Float32s | None = None
        self._session: Session | None = None
        self._bind: Background[Session] | None = None
        self.takers: list[Callable[[Float32s], None]] = [self._take]
        """Called with each solved shape, (n, 3). The next solve writes over the array."""
        self.all_stats: list[SolveStats] = []
        """One for each solved shape."""
        self._inputs = read_input(obj, depsgraph_of(scene))
        self._check_ready(obj, depsgraph_of(scene))
        session = mesh.fitting(obj, self._inputs)
        if session is not None:
            self._take_live(session)
        sessions.lock(obj, self)

    @property
    def fraction(self) -> float:
        return self._n_done / self.n_shapes

    @property
    def n_unsettled(self) -> int:
        """The number of solved shapes that have not converged."""
        return sum(stats.stop_reason != "converged" for stats in self.all_stats)

    @property
    def warning(self) -> str:
        """One sentence if shapes have not converged, else ''."""
        n = self.n_unsettled
        return f"{n} of {self.n_shapes} solves are not finished: raise Max Iterations (Advanced)" if n else ""

    @property
    def bind_fraction(self) -> float | None:
        """The part of the bind that is done; None if there is no bind under way."""
        return None if self._bind is None else self._bind.fraction

    @property
    def stage_fraction(self) -> float:
        return self.fraction if self._bind is None or self._n_done else self._bind.fraction

    @property
    def status(self) -> str:
        # With an animated scale each frame has a bind of its own: then only the first is told.
        if self._bind is not None and not self._n_done:
            return f"preparing the mesh, {self._bind.fraction:.0%}"
        return f"{self._shape_name()}, {self.fraction:.0%} done"

    def step(self, time_limit_s: float = STEP_S) -> bool:
        """Works for about ``time_limit_s``; True while there is more to do. After the last step, call finish().

        Raises:
            ValueError, RuntimeError: a handle, the object or the scene is gone, the mesh has changed or cannot be used,
                or the solver failed.
        """
        if self._session is None and self._bind is None:
            self._begin_bind(self._inputs)
        is_solved = self._n_done == self.n_shapes
        if not is_solved:
            self._work(time_limit_s)
        is_more = self._n_done < self.n_shapes or self._conclude(time_limit_s if is_solved else 0.0)
        self._is_done = not is_more
        return is_more

    def finish(self) -> Result:
        """Writes the result, and puts everything else back to where it was at the start.

        Raises:
            ValueError, RuntimeError: as step(), or the result cannot be written; then nothing is written.
        """
        if not self._is_done:
            job = f"The {self.noun} of '{self.object_name}'"
            raise RuntimeError(f"{job} is not done: call step() until it returns False")
        result = self._write(self._object())
        sessions.set_stats(self.uid, self.all_stats[-1])
        self._go_back()
        return result

    def cancel(self) -> None:
        if self._bind is not None:
            self._bind.drop()
        self._go_back()

    @abstractmethod
    def _check_ready(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        """Raises ValueError if the work would be for nothing."""

    @abstractmethod
    def _shape_name(self) -> str:
        """The name of the shape that is solved now, for the status bar."""

    @abstractmethod
    def _begin_shape(self) -> None:
        """Sets the matrices of the handles for the next shape, or begins a bind if the shape needs one."""

    @abstractmethod
    def _is_from_rest(self) -> bool:
        """Whether the next shape starts from rest, else from the shape before."""

    @abstractmethod
    def _take(self, shape: Float32s) -> None:
        """Takes a solved shape of the mesh: the first of ``takers``."""

    @abstractmethod
    def _write(self, obj: bpy.types.Object) -> Result:
        """Writes the result when all shapes are solved."""

    def _conclude(self, _time_limit_s: float) -> bool:
        """A step of the work after the last shape; True while there is more."""
        return False

    def _work(self, time_limit_s: float) -> None:
        if self._bind is None and self._matrices is None:
            self._begin_shape()
        if self._bind is None:
            self._solve(time_limit_s)
        elif not self._bind.step(time_limit_s):
            self._end_bind(self._bind.result())

    def _begin_bind(self, inputs: SessionInput) -> None:
        self._bind = Background(sessions.build(inputs))

    def _end_bind(self, session: Session) -> None:
        if self._session is None:
            self._scene()
            mesh.adopt(self._object(), self._inputs, session)
            self._has_bound = True
            self._take_live(session)
        else:
            session.set_positions(self._session.positions)
            self._session = session
        self._bind = None

    def _take_live(self, session: Session) -> None:
        self._session = self._live_session = session
        self._live_positions = session.positions.copy()

    def _solve(self, time_limit_s: float) -> None:
        assert self._session is not None
        assert self._matrices is not None
        left = self._inputs.settings.max_iterations - sum(part.iterations for part in self._parts)
        if self._is_from_rest() and not self._parts:
            part = mesh.solve_from_rest(self._session, self._matrices, time_limit_s=time_limit_s)
        else:
            part = self._session.update(
                self._matrices, iterations=left, initial_guess="previous", time_limit_s=time_limit_s
            )
        self._parts.append(part)
        if part.stop_reason != "time_limit" or part.iterations >= left:
            self._end_shape(self._session)

    def _end_shape(self, session: Session) -> None:
        for take in self.takers:
            take(session.positions)
        self.all_stats.append(stats_of_whole(self._parts))
        self._parts = []
        self._matrices = None
        self._n_done += 1

    def _go_back(self) -> None:
        if self._live_session is not None and self._live_positions is not None:
            self._live_session.set_positions(self._live_positions)
        sessions.unlock(self.uid, self)
        if self._has_bound:
            sessions.drop_idle(self.uid)

    def _scene(self) -> bpy.types.Scene:
        scene = known.find_scene(self._scene_uid)
        if scene is None:
            raise RuntimeError(f"Scene '{self._scene_name}' is gone: the {self.noun} has ended")
        return scene

    def _object(self) -> bpy.types.Object:
        obj = known.find(self.uid)
        if obj is None:
            raise RuntimeError(f"'{self.object_name}' is gone: the {self.noun} has ended")
        meshes.check_mesh(obj)
        n = len(obj.data.vertices)
        if n != self._inputs.counts[0]:
            raise RuntimeError(
                f"The mesh of '{obj.name}' has changed ({self._inputs.counts[0]} vertices, now {n}): "
                f"the {self.noun} has ended"
            )
        return obj


def check_in_scene(obj: bpy.types.Object | None, scene: bpy.types.Scene) -> None:
    """Raises ValueError if it is no mesh that can be posed, or not in the scene."""
    if obj is None or scene not in obj.users_scene:
        raise ValueError(
            f"'{obj.name if obj else 'Nothing'}' is not in scene '{scene.name}': choose one of its objects"
        )
    meshes.check_mesh(obj)


def depsgraph_of(scene: bpy.types.Scene) -> bpy.types.Depsgraph:
    """The evaluated scene."""
    if scene == bpy.context.scene:
        return bpy.context.evaluated_depsgraph_get()
    view_layer = scene.view_layers[0]
    view_layer.update()
    return view_layer.depsgraph
