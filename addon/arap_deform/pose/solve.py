# SPDX-License-Identifier: GPL-3.0-or-later
"""Solving to convergence: in one call, or in the background."""

from __future__ import annotations

from dataclasses import replace

import bpy

from ..core import sessions
from ..core.background import Progress, Steps, part
from ..core.job import BackgroundJob
from ..core.naming import counted
from ..core.session import Session
from ..core.session_data import SolveStats
from ..core.session_input import difference_of_bind
from ..core.sessions import Bound
from ..engine import mesh, ready
from ..engine.frame import look, write_pose
from ..engine.update import bind
from ..scene import handle_motion, known, meshes, pose_key, shape_keys
from ..scene.inputs import read_input
from ..ui import waiting

BIND_SHARE = 0.3  # of the progress of a solve that has to bind first


def solve(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None, progress: Progress | None = None
) -> SolveStats:
    """Poses the mesh for the present places of the handles, to convergence, and writes the shape key.

    Starts from rest, with the initial guess from the rotations of the handles: the same file gives the same result.

    Raises:
        ValueError, RuntimeError, Cancelled: as read_input() and sessions.build(); ValueError if the shape key would
            not show the pose; RuntimeError if a task uses the mesh. The mesh stays as it was.
    """
    depsgraph = depsgraph or bpy.context.evaluated_depsgraph_get()
    _check(obj)
    share = BIND_SHARE if look(obj, depsgraph, sessions.get(obj.session_uid))[1] else 0.0
    session = bind(obj, depsgraph, _part(progress, 0.0, share))
    matrices = handle_motion.handle_matrices(obj, depsgraph)
    result = mesh.solve_from_rest(session, matrices, progress=_part(progress, share, 1.0))
    write_pose(obj, pose_key.writable(obj), session, result)
    return result


def begin_solve(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None) -> SolveJob:
    """Checks everything and returns a job that does what solve() does, with the same result. Raises as solve()."""
    _check(obj)
    return SolveJob(obj, depsgraph or bpy.context.evaluated_depsgraph_get())


class SolveJob(BackgroundJob[SolveStats]):
    """A solve in the background, so that an operator can show progress and take Esc.

    Nothing in the file changes before finish(). If step() or finish() raises, call cancel(). It holds no Blender data.
    """

    doing = "it is solved"
    noun = "solve"

    def __init__(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> None:
        """Of a checked object: see begin_solve()."""
        self.uid = known.add(obj)
        self.object_name: str = obj.name  # for messages
        self._inputs = read_input(obj, depsgraph)
        ready.check(obj, depsgraph, self._inputs)
        self._matrices = handle_motion.handle_matrices(obj, depsgraph)
        self._former = sessions.get(obj.session_uid)
        self._session: Session | None = None
        sessions.drop(obj.session_uid)  # it is busy now
        sessions.lock(obj, self)
        super().__init__(self._steps())

    @property
    def status(self) -> str:
        text = "preparing the mesh, {:.0%}" if self._session is None else "solving, {:.0%}"
        return text.format(self.fraction)

    def finish(self) -> SolveStats:
        """Writes the shape key and keeps the session. Raises as solve()."""
        result = self._result()
        obj = known.find(self.uid)
        if obj is None or self._session is None:
            raise RuntimeError(f"'{self.object_name}' is gone: there is nothing to pose")
        reason = mesh.counts_problem(obj, self._inputs.counts)
        if reason:
            raise RuntimeError(f"{reason} while it was solved: solve again")
        # The stretch of the bind: differences of the scene's below the tolerance must not add up.
        sessions.put(self.uid, Bound(self._session, replace(self._inputs, stretch=self._session.stretch)))
        write_pose(obj, pose_key.writable(obj), self._session, result)
        sessions.unlock(self.uid, self)
        return result

    def cancel(self) -> None:
        super().cancel()
        sessions.unlock(self.uid, self)
        obj = known.find(self.uid)
        if obj is None or mesh.counts_problem(obj, self._inputs.counts):
            return
        if self._session is not None:
            mesh.adopt(obj, self._inputs, self._session)
        elif self._former is not None:
            sessions.put(self.uid, self._former)

    def _steps(self) -> Steps[SolveStats]:
        former = self._former
        share = BIND_SHARE if former is None or difference_of_bind(former.inputs, self._inputs) else 0.0
        session = yield from part(sessions.rebuild(self._inputs, former), 0.0, share)
        self._session = session
        return (yield from part(mesh.solving_from_rest(session, self._matrices), share, 1.0))


def _part(progress: Progress | None, start: float, end: float) -> Progress | None:
    """``progress`` for a part of the work, from ``start`` to ``end`` of the whole."""
    if progress is None:
        return None
    return lambda fraction: progress(start + fraction * (end - start))


def solve_with_progress(context: bpy.types.Context, obj: bpy.types.Object) -> SolveStats:
    """As solve(), with progress at the mouse: for operators whose redo panel solves again at every change."""
    with waiting.at_mouse() as progress:
        return solve(obj, context.evaluated_depsgraph_get(), progress)


def unsettled_text(stats: SolveStats) -> str:
    """A warning if a solve has not converged, else ''."""
    if stats.stop_reason == "converged":
        return ""
    return f"Not finished after {counted(stats.iterations, 'iteration')}: raise Max Iterations (Advanced)"


def _check(obj: bpy.types.Object) -> None:
    meshes.check_mesh(obj)
    sessions.check_free(obj)
    shape_keys.check_writable(obj)
    existing = pose_key.find(obj)
    if existing is not None:
        shape_keys.check_shown(obj, existing)
    else:
        shape_keys.check_none_alone(obj, None)
