# SPDX-License-Identifier: GPL-3.0-or-later
"""The live sessions of objects: how one is made, which task has a mesh, what the last solve did. No Blender data.

They are kept by the session_uid of the object: references to Blender's objects do not survive an undo.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

from . import native
from .background import Steps, part
from .session import Session
from .session_data import SolveStats
from .session_input import SessionInput, difference_of_bind


@dataclass
class Bound:
    """A session and what it was made from."""

    session: Session
    inputs: SessionInput


class Identified(Protocol):
    """An object."""

    session_uid: int
    name: str


class Lock(Protocol):
    """Something that has a mesh for itself."""

    @property
    def doing(self) -> str:
        """What goes on: 'it is baked', for example."""


locks: dict[int, Lock] = {}
"""Who has a mesh for itself, by uid of the object. Read it; only lock() and unlock() change it."""

LARGE_VERTICES = 10_000  # with fewer, what is freed is not worth the trimming
IDLE_VERTICES = 100_000
"""What idle sessions may hold together: a session takes about 3.5 kB a vertex. The last one may be larger."""

_bound: dict[int, Bound] = {}  # the last one that was put is the last
_holders: set[tuple[int, str]] = set()  # uids of objects, and who comes back to their sessions
_stats: dict[int, SolveStats] = {}


def get(uid: int) -> Bound | None:
    return _bound.get(uid)


def put(uid: int, bound: Bound) -> None:
    """Makes it the live session of the object. Idle sessions go, the oldest first, if there is too much of them."""
    _bound.pop(uid, None)
    _bound[uid] = bound
    n_idle, too_much = 0, []
    for other in reversed(_bound):
        if not _is_held(other) and other not in locks:
            n_idle += _bound[other].inputs.counts[0]
            if n_idle > IDLE_VERTICES and other != uid:
                too_much.append(other)
    _give_back(too_much)


def hold(uid: int, who: str) -> None:
    """The session of the object is not idle until release(): somebody, Follow for example, comes back to it."""
    _holders.add((uid, who))


def release(uid: int, who: str) -> None:
    _holders.discard((uid, who))


def _is_held(uid: int) -> bool:
    return any(held == uid for held, _ in _holders)


def drop(uid: int) -> None:
    """Forgets the session, which may still be in use elsewhere; its stats stay for the panel."""
    _bound.pop(uid, None)


def drop_idle(uid: int) -> None:
    """Gives back the memory of a session that nobody uses, unless it is held."""
    if not _is_held(uid):
        _give_back([uid])


def _give_back(uids: Iterable[int]) -> None:
    n_gone = 0
    for uid in uids:
        if uid in _bound:
            n_gone += _bound.pop(uid).inputs.counts[0]
    if n_gone >= LARGE_VERTICES:
        _trim()


def _trim() -> None:
    """Gives freed memory back. The C library of Linux keeps it for the process; those of other systems do not."""
    if sys.platform == "linux":
        malloc_trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # only glibc has it
        if malloc_trim is not None:
            malloc_trim(0)


def forget(uids: Iterable[int]) -> None:
    """Forgets sessions and stats of objects that are gone. A task ends by itself."""
    gone = set(uids)
    _give_back(gone)
    for uid in gone:
        _stats.pop(uid, None)
    _holders.difference_update([holder for holder in _holders if holder[0] in gone])


def clear() -> None:
    """Forgets everything: another file was loaded."""
    _give_back(list(_bound))
    _holders.clear()
    _stats.clear()
    locks.clear()


def check_free(obj: Identified) -> None:
    """Raises RuntimeError if a task has the mesh for itself."""
    if obj.session_uid in locks:
        raise RuntimeError(f"Wait for '{obj.name}': {locks[obj.session_uid].doing}")


def lock(obj: Identified, holder: Lock) -> None:
    """The task has the mesh for itself from now on, until unlock(): Follow waits. Raises as check_free()."""
    check_free(obj)
    locks[obj.session_uid] = holder


def unlock(uid: int, holder: Lock) -> None:
    """Does nothing if the task does not have the mesh, as after another file was loaded."""
    if locks.get(uid) is holder:
        del locks[uid]


def locked_by(uid: int) -> str:
    """What is done with the mesh, '' if no task has it for itself."""
    return locks[uid].doing if uid in locks else ""


def stats(uid: int) -> SolveStats | None:
    return _stats.get(uid)


def set_stats(uid: int, value: SolveStats) -> None:
    _stats[uid] = value


def build(inputs: SessionInput) -> Steps[Session]:
    """Binds and factorizes. Touches no Blender data.

    Raises:
        ValueError: the mesh cannot be used. RuntimeError: no native module, or the solver failed.
    """
    binding = Session.bind(
        native.load(),
        inputs.mesh,
        inputs.stretch,
        inputs.settings,
        stiffness=inputs.stiffness,
        rigid_regions=inputs.rigid_regions,
        mirrors=inputs.mirrors,
    )
    session = yield from part(binding, 0.0, 0.5)
    yield from part(session.set_handles(inputs.specs, inputs.shown), 0.5, 1.0)
    return session


def rebuild(inputs: SessionInput, former: Bound | None) -> Steps[Session]:
    """build(), or the former session with the handles of ``inputs`` if its bind fits.

    Meanwhile the former one is busy, so it must not be the object's live session. It is as it was if this raises or is
    dropped.

    Raises:
        As build().
    """
    if former is None or difference_of_bind(former.inputs, inputs):
        return (yield from build(inputs))
    yield from former.session.set_handles(inputs.specs, inputs.shown)
    former.session.settings = inputs.settings
    return former.session
