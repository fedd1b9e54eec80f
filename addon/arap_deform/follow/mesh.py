# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done with the live session of an object: adopted, held against the scene, updated, its pose written.

For whoever has the mesh, an act or Live: nobody is asked here. Scripts come in through api, which asks.
"""

from __future__ import annotations

from dataclasses import replace

import bpy

from ..core import sessions
from ..core.arrays import Floats
from ..core.session import Progress, Session
from ..core.session_data import Readout
from ..core.sessions import Bound, Hold, SessionInput
from ..scene import handle_motion, meshes, pose_key, shape_keys
from ..scene.inputs import counts_of, enabled_stiffness, read_input, settings_of


def adopt(obj: bpy.types.Object, inputs: SessionInput, session: Session) -> None:
    """As api.adopt_session()."""
    reason = counts_problem(obj, inputs)
    if reason:
        raise RuntimeError(f"{reason} while it was being prepared: start again")
    sessions.put(obj.name, Bound(session, inputs))
    sync(obj)


def sync(obj: bpy.types.Object) -> None:
    """As api.sync_session()."""
    bound = sessions.get(obj.name)
    if bound is None:
        return
    pose_key.tell_session(obj)
    key = pose_key.find(obj)
    if key is None:
        bound.session.reset()
    else:
        bound.session.set_positions(shape_keys.read(key))


def refresh(obj: bpy.types.Object, bound: Bound, inputs: SessionInput) -> None:
    """Brings a session up to date whose bind and handles fit ``inputs``; it starts from the pose shown."""
    bound.session.settings = inputs.settings
    # The stretch stays the one that was bound: differences below the tolerance must not add up.
    bound.inputs = replace(inputs, stretch=bound.inputs.stretch)
    sync(obj)


def fitting(obj: bpy.types.Object, inputs: SessionInput) -> Session | None:
    """The object's live session, brought up to date, where ``inputs`` need no bind and no factorization; else None."""
    bound = sessions.get(obj.name)
    if bound is None or sessions.difference_of_bind(bound.inputs, inputs) or not _has_same_specs(bound.inputs, inputs):
        return None
    refresh(obj, bound, inputs)
    return bound.session


def update(
    obj: bpy.types.Object,
    matrices: Floats,
    *,
    iterations: int | None = None,
    initial_guess: str | None = None,
    time_limit_s: float | None = None,
    sufficient_accuracy: float = 0.0,
    is_from_rest: bool = False,
) -> Readout:
    """As api.update_pose(), where problem() has found none. ``matrices``: (h, 4, 4), as Session.update() takes them."""
    bound = sessions.get(obj.name)
    assert bound is not None
    bound.session.settings = settings_of(obj)
    key = writable_key(obj)
    if is_from_rest:
        result = solve_from_rest(
            bound.session, matrices, time_limit_s=time_limit_s, sufficient_accuracy=sufficient_accuracy
        )
    else:
        result = bound.session.update(
            matrices,
            iterations=iterations,
            initial_guess=initial_guess,
            time_limit_s=time_limit_s,
            sufficient_accuracy=sufficient_accuracy,
        )
    write_pose(obj, key, bound.session, result)
    return result


def solve_from_rest(
    session: Session,
    matrices: Floats,
    progress: Progress | None = None,
    time_limit_s: float | None = None,
    sufficient_accuracy: float = 0.0,
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
            sufficient_accuracy=sufficient_accuracy,
        )
    except BaseException:
        session.set_positions(before)
        raise


def problem(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    *,
    is_thorough: bool,
    holds: tuple[Hold, ...] | None = None,
    use_nodes: bool | None = False,
) -> str:
    """As api.check_live()."""
    bound = sessions.get(obj.name)
    if bound is None:
        return f"'{obj.name}' is not being posed"
    if pose_key.name_of(obj) != bound.inputs.key_name:
        return sessions.key_differs(obj.name)  # the pose would show twice, in the former key and in this one
    try:
        meshes.check_mesh(obj)
        if is_thorough:
            fresh = read_input(obj, depsgraph, use_nodes=use_nodes)
            return sessions.difference_of_bind(bound.inputs, fresh) or (
                "" if _has_same_specs(bound.inputs, fresh) else sessions.groups_differ(obj.name)
            )
        stretch = meshes.read_stretch(obj, depsgraph)
    except ValueError as error:
        return str(error)
    reason = counts_problem(obj, bound.inputs)
    if reason:
        return reason
    if (handle_motion.enabled_holds(obj) if holds is None else holds) != bound.inputs.holds:
        return sessions.groups_differ(obj.name)
    if settings_of(obj).of_bind != bound.inputs.settings.of_bind:
        return sessions.settings_differ(obj.name)
    if enabled_stiffness(obj) != bound.inputs.stiff_groups:
        return sessions.stiffness_differs(obj.name)
    return "" if sessions.is_same_stretch(bound.inputs.stretch, stretch) else sessions.stretch_differs(obj.name)


def counts_problem(obj: bpy.types.Object, inputs: SessionInput) -> str:
    """Why the mesh is no longer the one that ``inputs`` were read of, '' while it is."""
    before, now = inputs.signature.counts, counts_of(obj)
    return "" if now == before else sessions.counts_differ(obj.name, before, now)


def writable_key(obj: bpy.types.Object) -> bpy.types.ShapeKey:
    """The live key, made where missing. Raises ValueError where it would not show what is written."""
    shape_keys.check_writable(obj)
    pose_key.check_name(obj)
    key = pose_key.ensure(obj)
    shape_keys.check_shown(obj, key)
    return key


def write_pose(obj: bpy.types.Object, key: bpy.types.ShapeKey, session: Session, result: Readout) -> None:
    """Shows where the session is, and remembers what the solve did."""
    shape_keys.write(obj, key, session.positions)
    shape_keys.show(key)
    sessions.set_readout(obj.name, result)


def _has_same_specs(old: SessionInput, new: SessionInput) -> bool:
    """Whether both hold the same and from the same places: a pull may hold what handles hold, but not from rest."""
    return len(old.specs) == len(new.specs) and all(
        a.is_same_as(b) and a.base is b.base for a, b in zip(old.specs, new.specs, strict=True)
    )
