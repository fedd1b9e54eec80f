# SPDX-License-Identifier: GPL-3.0-or-later
"""Solving to the end: at once, or in a thread of its own."""

from __future__ import annotations

import bpy

from ..core import sessions
from ..core.job import STEP_S
from ..core.models import Progress
from ..core.session import Session
from ..core.session_data import Readout
from ..core.session_input import difference_of_bind
from ..core.sessions import Bound
from ..core.worker import Binding
from ..follow import mesh
from ..follow.frame import Frame, write_pose
from ..follow.update import prepare_session
from ..scene import handle_motion, meshes, pose_key, shape_keys
from ..scene.inputs import read_input

BIND_SHARE = 0.3  # of the progress that a solve shows, where it has to bind first


def solve(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None, progress: Progress | None = None
) -> Readout:
    """Poses the mesh for the handles where they are now, to convergence, and writes the key.

    Starts from rest with the guess from the handles' rotations: the same file gives the same result.

    Raises:
        As read_input() and sessions.build(); ValueError where the key would not show the pose; RuntimeError where an
        act has the mesh for itself. The mesh stays as it was in each case.
    """
    depsgraph = depsgraph or bpy.context.evaluated_depsgraph_get()
    _check(obj)
    share = BIND_SHARE if Frame(obj, depsgraph).problem else 0.0
    session = prepare_session(obj, depsgraph, sessions.part(progress, 0.0, share))
    matrices = handle_motion.handle_matrices(obj, depsgraph)
    result = mesh.solve_from_rest(session, matrices, sessions.part(progress, share, 1.0))
    write_pose(obj, pose_key.writable(obj), session, result)
    return result


def begin_solve(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> SolveJob:
    """Checks everything and returns a job that does what solve() does, with the same result. Raises as solve()."""
    _check(obj)
    return SolveJob(obj, depsgraph or bpy.context.evaluated_depsgraph_get())


class SolveJob:
    """A solve in a worker thread, so that an operator can show progress and take Esc meanwhile.

    Nothing in the file changes before finish(). Where step() or finish() raises, call cancel(). Holds names, no Blender
    data.
    """

    doing = "it is solved"
    noun = "solve"

    def __init__(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        """Of a checked object: see begin_solve()."""
        self.object_name: str = obj.name
        self._inputs = read_input(obj, depsgraph)
        self._matrices = handle_motion.handle_matrices(obj, depsgraph)
        self._former = sessions.get(obj.name)
        self._is_bound = self._former is not None and not difference_of_bind(self._former.inputs, self._inputs)
        self._session: Session | None = None
        self._work = Binding(self._run)
        sessions.drop(obj.name)  # busy from here on
        sessions.claim(obj.name, self)

    @property
    def fraction(self) -> float:
        """Done so far, 0 to 1."""
        return self._work.fraction

    @property
    def status(self) -> str:
        """What is being done, for the status bar."""
        text = "preparing the mesh, {:.0%}" if self._session is None else "solving, {:.0%}"
        return text.format(self.fraction)

    def step(self, time_limit_s: float = STEP_S) -> bool:
        """Waits for so long at most; True while there is more to do. Call finish() after the last."""
        self._work.start()  # not when the job is made: that may be within an operator, see Binding
        self._work.wait(time_limit_s)
        return not self._work.is_done

    def finish(self) -> Readout:
        """Writes the key; the session is the object's live one.

        Raises:
            As solve().
        """
        result = self._work.result()
        obj = bpy.data.objects.get(self.object_name)
        if obj is None or self._session is None:
            raise RuntimeError(f"'{self.object_name}' is not there any more: there is nothing to pose")
        reason = mesh.counts_problem(obj, self._inputs)
        if reason:
            raise RuntimeError(f"{reason} while it was solved: solve again")
        sessions.put(self.object_name, Bound(self._session, self._inputs))
        write_pose(obj, pose_key.writable(obj), self._session, result)
        sessions.release(self.object_name, self)
        return result

    def cancel(self) -> None:
        """Everything as before."""
        self._work.drop()
        sessions.release(self.object_name, self)
        if self._work.has_started and (self._is_bound or self._session is not None):
            self._work.wait()  # the session is in use for as long as an iteration
        obj = bpy.data.objects.get(self.object_name)
        if obj is None or mesh.counts_problem(obj, self._inputs):
            return
        if self._session is not None:
            mesh.adopt(obj, self._inputs, self._session)
        elif self._former is not None:
            sessions.put(self.object_name, self._former)

    def _run(self, progress: Progress) -> Readout:
        share = 0.0 if self._is_bound else BIND_SHARE
        session = sessions.rebuild(self._inputs, self._former, sessions.part(progress, 0.0, share))
        self._session = session
        return mesh.solve_from_rest(session, self._matrices, sessions.part(progress, share, 1.0))


def _check(obj: bpy.types.Object) -> None:
    meshes.check_mesh(obj)
    sessions.check_free(obj.name)
    shape_keys.check_writable(obj)
    existing = pose_key.find(obj)
    if existing is not None:
        shape_keys.check_shown(obj, existing)
