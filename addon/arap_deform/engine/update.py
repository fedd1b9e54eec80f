# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing by a script: the session, and one update of the mesh. Both are refused while a task has the mesh."""

from __future__ import annotations

import bpy

from ..core import sessions
from ..core.background import Progress, run
from ..core.session import Session
from ..core.session_data import SolveStats
from ..scene import meshes
from ..scene.inputs import read_input
from . import frame, mesh, ready

SCRIPT = "a script"  # see sessions.hold()


def prepare_session(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None, progress: Progress | None = None
) -> Session:
    """As bind(), and the session is kept until end_session()."""
    session = bind(obj, depsgraph or bpy.context.evaluated_depsgraph_get(), progress)
    sessions.hold(obj.session_uid, SCRIPT)
    return session


def end_session(obj: bpy.types.Object) -> None:
    """Gives back the memory of prepare_session(): some kilobytes a vertex. The pose stays.

    Raises:
        RuntimeError: a task has the mesh for itself.
    """
    sessions.check_free(obj)
    sessions.release(obj.session_uid, SCRIPT)
    sessions.drop_idle(obj.session_uid)


def bind(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, progress: Progress | None = None) -> Session:
    """The object's live session, made, or brought up to date.

    A session that fits is kept; changed groups only factorize again; a changed mesh, scale or setting binds again.
    The session starts from the pose that the key shows.

    Raises:
        As read_input(), ready.check() and sessions.build(), Cancelled, or RuntimeError if a task has the mesh for
        itself. A session that was there before stays.
    """
    meshes.check_mesh(obj)
    sessions.check_free(obj)
    inputs = read_input(obj, depsgraph)
    ready.check(obj, depsgraph, inputs)
    session = run(sessions.rebuild(inputs, sessions.get(obj.session_uid)), progress)
    mesh.adopt(obj, inputs, session)
    return session


def update_pose(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph | None = None,
    *,
    iterations: int | None = None,
    initial_guess: str | None = None,
    time_limit_s: float | None = None,
) -> SolveStats:
    """One live update: reads the handles, solves a few iterations, writes the key.

    Needs a live session (prepare_session). ``stop_reason`` is "converged" when nothing is left to do
    at these handles.

    Args:
        depsgraph: to read the handles from.
        iterations, initial_guess, time_limit_s: see Session.update().

    Raises:
        RuntimeError: no live session, the mesh or scale has changed under it (the session has then ended), or a task
            has the mesh for itself.
        ValueError: the key would not show the pose, or a handle cannot work; nothing has changed.
    """
    sessions.check_free(obj)
    bound = sessions.get(obj.session_uid)
    snapshot, misfit = frame.look(obj, depsgraph or bpy.context.evaluated_depsgraph_get(), bound)
    if snapshot is None or bound is None or misfit:
        sessions.drop(obj.session_uid)
        raise RuntimeError(f"{misfit}: start posing again")
    return frame.solve(
        snapshot,
        bound,
        snapshot.motions(),
        iterations=iterations,
        initial_guess=initial_guess,
        time_limit_s=time_limit_s,
    )
