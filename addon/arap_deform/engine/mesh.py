# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done with the live session of an object: it is bound in the background, adopted, and brought up to date.

For the task or the Follow run that has the mesh: nothing here asks who has it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import bpy
import numpy as np

from ..core import sessions
from ..core.arrays import Float32s, Floats
from ..core.background import Background, Steps
from ..core.session import Session
from ..core.session_data import SolveStats
from ..core.session_input import Counts, SessionInput, counts_differ, difference
from ..core.sessions import Bound
from ..scene import known, pose_key, versions
from ..scene.snapshot import counts_of


def adopt(obj: bpy.types.Object, inputs: SessionInput, session: Session) -> None:
    """Makes ``session`` the object's live one and starts it from the pose shown. Main thread only.

    Raises:
        RuntimeError: the mesh has changed since ``inputs`` were read.
    """
    reason = counts_problem(obj, inputs.counts)
    if reason:
        raise RuntimeError(f"{reason} while it was being prepared: start again")
    # Keep stretch and planes of the bind: differences below the tolerance must not add up.
    sessions.put(known.add(obj), Bound(session, replace(inputs, stretch=session.stretch, mirrors=session.mirrors)))
    sync(obj)


def sync(obj: bpy.types.Object) -> bool:
    """Lets the live session, if any, go on from the pose that the key shows now: after an undo, for example.

    Returns:
        Whether that is another pose than the session's.
    """
    bound = sessions.get(obj.session_uid)
    if bound is None:
        return True
    pose_key.update_session_key(obj)
    key = pose_key.find(obj)
    if key is None:
        bound.session.reset()
        return True
    positions = versions.read_key(key)
    if np.array_equal(positions, bound.session.positions):
        return False
    bound.session.set_positions(positions)
    return True


def fitting(obj: bpy.types.Object, inputs: SessionInput) -> Session | None:
    """The object's live session, brought up to date, if ``inputs`` need no bind and no factorization; else None."""
    bound = sessions.get(obj.session_uid)
    if bound is None or difference(bound.inputs, inputs):
        return None
    bound.session.settings = inputs.settings
    adopt(obj, inputs, bound.session)
    return bound.session


def solve_from_rest(session: Session, matrices: Floats, **options: Any) -> SolveStats:
    """Starts from rest, with a guess from the rotations of the handles, and goes to convergence or the time limit.

    Args:
        session: to solve with.
        matrices: (h, 4, 4) object-space motions.
        options: others of Session.update().

    Raises:
        As Session.update(). The session is then as it was.
    """
    with _from_rest(session):
        return session.update(matrices, initial_guess="handle_rotations", to_convergence=True, **options)


def solving_from_rest(session: Session, matrices: Floats) -> Steps[SolveStats]:
    """As solve_from_rest(), in the background. If the work is dropped, the session is as it was."""
    with _from_rest(session):
        return (yield from session.updating(matrices, initial_guess="handle_rotations", to_convergence=True))


@contextmanager
def _from_rest(session: Session) -> Iterator[None]:
    """Resets the session; if what follows does not come to its end, the session is as it was."""
    before = session.positions.copy()
    session.reset()
    try:
        yield
    except BaseException:
        session.set_positions(before)
        raise


def counts_problem(obj: bpy.types.Object, before: Counts) -> str:
    """Why the mesh is no longer the one that had ``before``, '' while it is."""
    now = counts_of(obj)
    return "" if now == before else counts_differ(obj.name, before, now)


class SessionBinding(Background[Session]):
    """Binds a session, or gives the live session other handles if that is enough."""

    def __init__(self, obj: bpy.types.Object, inputs: SessionInput, start: Float32s | None = None) -> None:
        """Begins.

        Args:
            inputs: from read_input().
            start: (n, 3) positions to begin with; None: the pose that the key has.
        """
        self._uid = known.add(obj)
        self._inputs = inputs
        self._start_positions = start
        self._former = sessions.get(self._uid)
        sessions.drop(self._uid)  # the session is busy until adopt() or drop()
        super().__init__(sessions.rebuild(inputs, self._former))

    def drop(self) -> None:
        """Ends the work. The former session is the live one again, unless it has the new handles already."""
        was_done = self.is_done
        super().drop()
        if not was_done:
            self._put_back()

    def adopt(self) -> None:
        """Makes the result the live session. Raises what the bind raised; the former session is then live again."""
        try:
            session = self.result()
        except BaseException:
            self._put_back()
            raise
        obj = known.find(self._uid)
        if obj is None:
            raise RuntimeError("The mesh was deleted while it was being prepared")
        adopt(obj, self._inputs, session)
        if self._start_positions is not None:
            session.set_positions(self._start_positions)

    def _put_back(self) -> None:
        if self._former is not None and sessions.get(self._uid) is None:
            sessions.put(self._uid, self._former)
