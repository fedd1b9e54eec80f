# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing: sessions, and one update of the mesh. What changes either is refused while an act has the mesh."""

from __future__ import annotations

import bpy

from ..core import native, sessions
from ..core.session import Progress, Session
from ..core.session_data import Readout
from ..core.sessions import Bound, SessionInput
from ..scene import handle_motion, meshes
from ..scene.inputs import read_input
from . import mesh


def session_input(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None, *, use_nodes: bool | None = None
) -> SessionInput:
    """Reads mesh, groups and settings. Main thread only. ``use_nodes``: False within handlers, see versions.

    Raises:
        ValueError: not a mesh, in Edit Mode, linked or shared data, absolute keys, singular scale, a pin or handle
            without its group or object, a handle whose group has no weights, nothing pinned or handled.
    """
    return read_input(obj, depsgraph or bpy.context.evaluated_depsgraph_get(), use_nodes=use_nodes)


def build_session(inputs: SessionInput, progress: Progress | None = None) -> Session:
    """Binds and factorizes. Touches no Blender data: may run in a worker thread; ``progress`` is called there.

    Raises:
        ValueError: the mesh cannot be used. RuntimeError: no native module, or the solver failed. Cancelled.
    """
    session = Session(
        native.load(),
        inputs.mesh,
        inputs.stretch,
        inputs.settings,
        stiffness=inputs.stiffness,
        rigid_regions=inputs.rigid_regions,
        progress=part(progress, 0.0, 0.5),
    )
    session.set_handles(inputs.specs, progress=part(progress, 0.5, 1.0))
    return session


def rebuild_session(inputs: SessionInput, former: Bound | None, progress: Progress | None = None) -> Session:
    """build_session(), or the former session with the handles of ``inputs`` where its bind fits.

    The former one must not be the object's live one any more: while this runs, in whatever thread, it is busy.

    Raises:
        As build_session().
    """
    if former is None or sessions.difference_of_bind(former.inputs, inputs):
        return build_session(inputs, progress)
    former.session.set_handles(inputs.specs, progress)
    former.session.settings = inputs.settings
    return former.session


def adopt_session(obj: bpy.types.Object, inputs: SessionInput, session: Session) -> None:
    """Makes ``session`` the object's live one and starts it from the pose shown. Main thread only.

    Raises:
        RuntimeError: the mesh has changed since ``inputs`` were read, or an act has it for itself.
    """
    sessions.check_free(obj.name)
    mesh.adopt(obj, inputs, session)


def sync_session(obj: bpy.types.Object) -> None:
    """Lets the live session, if any, go on from the pose that the key shows now: after an undo, for example.

    Raises:
        RuntimeError: an act has the mesh for itself.
    """
    sessions.check_free(obj.name)
    mesh.sync(obj)


def prepare_session(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None, progress: Progress | None = None
) -> Session:
    """The object's live session, made or brought up to date by session_input, build_session and adopt_session.

    A session that fits is kept; changed groups only factorize again; a changed mesh, scale or setting binds again.
    The session starts from the pose that the key shows.

    Raises:
        As session_input() and build_session(), or RuntimeError where an act has the mesh for itself. A session that
        was there before stays.
    """
    meshes.check_mesh(obj)
    sessions.check_free(obj.name)
    inputs = session_input(obj, depsgraph)
    bound = sessions.get(obj.name)
    if bound is None or sessions.difference_of_bind(bound.inputs, inputs):
        mesh.adopt(obj, inputs, build_session(inputs, progress))
    else:
        bound.session.set_handles(inputs.specs, progress)
        mesh.refresh(obj, bound, inputs)
    fresh = sessions.get(obj.name)
    assert fresh is not None
    return fresh.session


def check_live(obj: bpy.types.Object, is_thorough: bool = False) -> str:
    """Why the object's live session no longer fits the scene, one sentence; '' while it does.

    Args:
        obj: the mesh.
        is_thorough: compare topology, rest shape and weights too (milliseconds); False: counts, scale and
            settings (microseconds).
    """
    return mesh.problem(obj, bpy.context.evaluated_depsgraph_get(), is_thorough=is_thorough)


def end_session(obj_or_name: bpy.types.Object | str) -> None:
    """Forgets the live session, if any. The pose stays."""
    sessions.drop(obj_or_name if isinstance(obj_or_name, str) else obj_or_name.name)


def readout(obj_or_name: bpy.types.Object | str) -> Readout | None:
    """What the last solve of this object did, for the panel; None before the first."""
    return sessions.readout(obj_or_name if isinstance(obj_or_name, str) else obj_or_name.name_full)


def update_pose(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph | None = None,
    *,
    iterations: int | None = None,
    initial_guess: str | None = None,
    time_limit_s: float | None = None,
    is_from_rest: bool = False,
) -> Readout:
    """One live update: reads the handles, solves a few iterations, writes the key.

    Needs a live session (prepare_session or adopt_session). ``stop_reason`` is "converged" when nothing is left to do
    at these handles.

    Args:
        obj: the mesh.
        depsgraph: to read the handles from.
        iterations, initial_guess, time_limit_s: see Session.update().
        is_from_rest: as solve() does, from the defined start, to convergence or the time limit.

    Raises:
        RuntimeError: no live session, the mesh or scale has changed under it (the session has then ended), or an act
            has the mesh for itself.
        ValueError: the key would not show the pose, or a handle cannot work; nothing has changed.
    """
    sessions.check_free(obj.name)
    depsgraph = depsgraph or bpy.context.evaluated_depsgraph_get()
    reason = mesh.problem(obj, depsgraph, is_thorough=False)
    if reason:
        sessions.drop(obj.name)
        raise RuntimeError(f"{reason}: start posing again")
    return mesh.update(
        obj,
        handle_motion.handle_matrices(obj, depsgraph),
        iterations=iterations,
        initial_guess=initial_guess,
        time_limit_s=time_limit_s,
        is_from_rest=is_from_rest,
    )


def part(progress: Progress | None, start: float, end: float) -> Progress | None:
    """``progress`` for a part of the work, from ``start`` to ``end`` of the whole."""
    if progress is None:
        return None
    return lambda fraction: progress(start + fraction * (end - start))
