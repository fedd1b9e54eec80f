# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing: sessions, and one update of the mesh."""

from __future__ import annotations

from dataclasses import replace

import bpy

from . import handle_io, live_key, mesh_io, native, sessions, shape_key, stiffness_io
from .handle_map import Floats
from .scene_input import counts_of, read_input, settings_of
from .session import Progress, Session
from .session_data import Readout
from .sessions import Hold, Live, SessionInput


def session_input(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None, *, use_nodes: bool | None = None
) -> SessionInput:
    """Reads mesh, groups and settings. Main thread only. ``use_nodes``: False within handlers, see mesh_io.

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


def rebuild_session(inputs: SessionInput, former: Live | None, progress: Progress | None = None) -> Session:
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
        RuntimeError: the mesh has changed since ``inputs`` were read.
    """
    reason = counts_problem(obj, inputs)
    if reason:
        raise RuntimeError(f"{reason} while it was being prepared: start again")
    sessions.put(obj.name, Live(session, inputs))
    sync_session(obj)


def sync_session(obj: bpy.types.Object) -> None:
    """Lets the live session, if any, go on from the pose that the key shows now: after an undo, for example."""
    live = sessions.get(obj.name)
    if live is None:
        return
    live_key.tell_session(obj)
    key = live_key.find(obj)
    if key is None:
        live.session.reset()
    else:
        live.session.set_positions(shape_key.read(key))


def prepare_session(
    obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph | None = None, progress: Progress | None = None
) -> Session:
    """The object's live session, made or brought up to date by session_input, build_session and adopt_session.

    A session that fits is kept; changed groups only factorize again; a changed mesh, scale or setting binds again.
    The session starts from the pose that the key shows.

    Raises:
        As session_input() and build_session(); a session that was there before stays.
    """
    inputs = session_input(obj, depsgraph)
    live = sessions.get(obj.name)
    if live is None or sessions.difference_of_bind(live.inputs, inputs):
        adopt_session(obj, inputs, build_session(inputs, progress))
    else:
        live.session.set_handles(inputs.specs, progress)
        _refresh(obj, live, inputs)
    fresh = sessions.get(obj.name)
    assert fresh is not None
    return fresh.session


def fitting_session(obj: bpy.types.Object, inputs: SessionInput) -> Session | None:
    """The object's live session, brought up to date, where ``inputs`` need no bind and no factorization; else None."""
    live = sessions.get(obj.name)
    if live is None or sessions.difference_of_bind(live.inputs, inputs) or not _has_same_specs(live.inputs, inputs):
        return None
    _refresh(obj, live, inputs)
    return live.session


def _refresh(obj: bpy.types.Object, live: Live, inputs: SessionInput) -> None:
    live.session.settings = inputs.settings
    # The stretch stays the one that was bound: differences below the tolerance must not add up.
    live.inputs = replace(inputs, stretch=live.inputs.stretch)
    sync_session(obj)


def _has_same_specs(old: SessionInput, new: SessionInput) -> bool:
    """Whether both hold the same and from the same places: a pull may hold what handles hold, but not from rest."""
    return len(old.specs) == len(new.specs) and all(
        a.is_same_as(b) and a.base is b.base for a, b in zip(old.specs, new.specs, strict=True)
    )


def check_live(
    obj: bpy.types.Object,
    is_thorough: bool = False,
    holds: tuple[Hold, ...] | None = None,
    *,
    use_nodes: bool | None = False,
) -> str:
    """Why the object's live session no longer fits the scene, one sentence; '' while it does.

    Args:
        obj: the mesh.
        is_thorough: compare topology, rest shape and weights too (milliseconds); False: counts, scale and
            settings (microseconds).
        holds: what the session holds; None: the pins and handles of the object.
        use_nodes: to read weights, see compat.read_group_weights(); only False within a handler.
    """
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return live_problem(obj, depsgraph, is_thorough=is_thorough, holds=holds, use_nodes=use_nodes)


def end_session(obj_or_name: bpy.types.Object | str) -> None:
    """Forgets the live session, if any. The pose stays."""
    sessions.drop(obj_or_name if isinstance(obj_or_name, str) else obj_or_name.name)


def readout(obj_or_name: bpy.types.Object | str) -> Readout | None:
    """What the last solve of this object did, for the panel; None before the first."""
    return sessions.readout(obj_or_name if isinstance(obj_or_name, str) else obj_or_name.name)


def update_pose(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph | None = None,
    *,
    iterations: int | None = None,
    initial_guess: str | None = None,
    time_limit_s: float | None = None,
    is_from_rest: bool = False,
    held: tuple[tuple[Hold, ...], Floats] | None = None,
) -> Readout:
    """One live update: reads the handles, solves a few iterations, writes the key.

    Needs a live session (prepare_session or adopt_session). ``stop_reason`` is "converged" when nothing is left to do
    at these handles.

    Args:
        obj: the mesh.
        depsgraph: to read the handles from.
        iterations, initial_guess, time_limit_s: see Session.update().
        is_from_rest: as solve() does, from the defined start, to convergence or the time limit.
        held: what the session holds and (h, 4, 4) how that has moved; None: the pins and handles of the object.

    Raises:
        RuntimeError: no live session, or the mesh or scale has changed under it (the session has then ended).
        ValueError: the key would not show the pose, or a handle cannot work; nothing has changed.
    """
    depsgraph = depsgraph or bpy.context.evaluated_depsgraph_get()
    reason = live_problem(obj, depsgraph, is_thorough=False, holds=held[0] if held else None)
    live = sessions.get(obj.name)
    if reason or live is None:
        end_session(obj)
        raise RuntimeError(f"{reason}: start posing again")
    live.session.settings = settings_of(obj)
    key = writable_key(obj)
    matrices = held[1] if held else handle_io.handle_matrices(obj, depsgraph)
    if is_from_rest:
        result = solve_from_rest(live.session, matrices, time_limit_s=time_limit_s)
    else:
        result = live.session.update(
            matrices, iterations=iterations, initial_guess=initial_guess, time_limit_s=time_limit_s
        )
    write_pose(obj, key, live.session, result)
    return result


def solve_from_rest(
    session: Session, matrices: Floats, progress: Progress | None = None, time_limit_s: float | None = None
) -> Readout:
    """Starts from rest with the guess from the handles' rotations, and goes to convergence or the time limit.

    Raises:
        As Session.update(); the session is then where it was.
    """
    before = session.positions.copy()
    session.reset()
    try:
        return session.update(
            matrices,
            initial_guess="handle_rotations",
            to_convergence=True,
            progress=progress,
            time_limit_s=time_limit_s,
        )
    except BaseException:
        session.set_positions(before)
        raise


def live_problem(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    *,
    is_thorough: bool,
    holds: tuple[Hold, ...] | None = None,
    use_nodes: bool | None = False,
) -> str:
    """As check_live()."""
    live = sessions.get(obj.name)
    if live is None:
        return f"'{obj.name}' is not being posed"
    if live_key.name_of(obj) != live.inputs.key_name:
        return sessions.key_differs(obj.name)  # the pose would show twice, in the former key and in this one
    try:
        mesh_io.check_mesh(obj)
        if is_thorough:
            fresh = read_input(obj, depsgraph, use_nodes=use_nodes)
            return sessions.difference_of_bind(live.inputs, fresh) or (
                "" if _has_same_specs(live.inputs, fresh) else sessions.groups_differ(obj.name)
            )
        stretch = mesh_io.read_stretch(obj, depsgraph)
    except ValueError as error:
        return str(error)
    reason = counts_problem(obj, live.inputs)
    if reason:
        return reason
    if (handle_io.enabled_holds(obj) if holds is None else holds) != live.inputs.holds:
        return sessions.groups_differ(obj.name)
    if settings_of(obj).of_bind != live.inputs.settings.of_bind:
        return sessions.settings_differ(obj.name)
    if stiffness_io.enabled_entries(obj) != live.inputs.stiff_groups:
        return sessions.stiffness_differs(obj.name)
    return "" if sessions.is_same_stretch(live.inputs.stretch, stretch) else sessions.stretch_differs(obj.name)


def counts_problem(obj: bpy.types.Object, inputs: SessionInput) -> str:
    """Why the mesh is no longer the one that ``inputs`` were read of, '' while it is."""
    before, now = inputs.signature.counts, counts_of(obj)
    return "" if now == before else sessions.counts_differ(obj.name, before, now)


def writable_key(obj: bpy.types.Object) -> bpy.types.ShapeKey:
    """The live key, made where missing. Raises ValueError where it would not show what is written."""
    shape_key.check_writable(obj)
    live_key.check_name(obj)
    key = live_key.ensure(obj)
    shape_key.check_shown(obj, key)
    return key


def write_pose(obj: bpy.types.Object, key: bpy.types.ShapeKey, session: Session, result: Readout) -> None:
    """Shows where the session is, and remembers what the solve did."""
    shape_key.write(obj, key, session.positions)
    shape_key.show(key)
    sessions.set_readout(obj.name, result)


def part(progress: Progress | None, start: float, end: float) -> Progress | None:
    """``progress`` for a part of the work, from ``start`` to ``end`` of the whole."""
    if progress is None:
        return None
    return lambda fraction: progress(start + fraction * (end - start))
