# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done with the live session of an object: adopted, held against the scene, updated, its pose written.

For whoever has the mesh, an act or Live: nobody is asked here. Scripts come in through api, which asks.
"""

from __future__ import annotations

from dataclasses import replace

import bpy

from ..core import sessions
from ..core.arrays import Floats
from ..core.models import Progress
from ..core.session import Session
from ..core.session_data import Readout
from ..core.sessions import Bound, SessionInput
from ..props import hooks
from ..scene import pose_key, shape_keys
from ..scene.inputs import counts_of


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
    if bound is None or sessions.difference(bound.inputs, inputs):
        return None
    refresh(obj, bound, inputs)
    return bound.session


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


def counts_problem(obj: bpy.types.Object, inputs: SessionInput) -> str:
    """Why the mesh is no longer the one that ``inputs`` were read of, '' while it is."""
    before, now = inputs.counts, counts_of(obj)
    return "" if now == before else sessions.counts_differ(obj.name, before, now)


def write_pose(obj: bpy.types.Object, key: bpy.types.ShapeKey, session: Session, result: Readout) -> None:
    """Shows where the session is, and remembers what the solve did."""
    shape_keys.write(obj, key, session.positions)
    shape_keys.show(key)
    sessions.set_readout(obj.name, result)
    for posed in hooks.posed:
        posed(obj)
