# SPDX-License-Identifier: GPL-3.0-or-later
"""The live sessions by object name: how one is made, which act has a mesh, what the last solve did. No Blender data.

They are kept by name because references to Blender's objects do not survive an undo. The names are of objects of this
file. So a caller with an object that may be linked, as panels have, asks for its full name.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Protocol, TypeAlias

from . import native
from .background import Steps, part
from .cages.session import CageSession
from .session import Session
from .session_data import Readout
from .session_input import SessionInput, difference_of_bind

AnySession: TypeAlias = Session | CageSession


@dataclass
class Bound:
    """A session and what it was made from."""

    session: AnySession
    inputs: SessionInput


class Act(Protocol):
    """Something that has a mesh for itself."""

    @property
    def doing(self) -> str:
        """What goes on: 'it is baked', for example."""


acts: dict[str, Act] = {}
"""The acts under way, by name of the object. Read it; only claim() and release() change it."""

LARGE_VERTICES = 10_000  # with fewer, what is freed is not worth the trimming
IDLE_VERTICES = 100_000
"""What idle sessions may hold together: a session takes about 3.5 kB a vertex. The last one may be larger."""

_bound: dict[str, Bound] = {}  # the last one that was put is the last
_holders: set[tuple[str, str]] = set()  # names of objects, and who comes back to their sessions
_readouts: dict[str, Readout] = {}


def get(object_name: str) -> Bound | None:
    return _bound.get(object_name)


def put(object_name: str, bound: Bound) -> None:
    """Makes it the live session of the object. Idle sessions go, the oldest first, if there is too much of them."""
    _bound.pop(object_name, None)
    _bound[object_name] = bound
    n_idle, too_much = 0, []
    for name in reversed(_bound):
        if not _is_held(name) and name not in acts:
            n_idle += _bound[name].inputs.counts[0]
            if n_idle > IDLE_VERTICES and name != object_name:
                too_much.append(name)
    _give_back(too_much)


def hold(object_name: str, who: str) -> None:
    """The session of the object is not idle until let_go(): somebody, Live for example, comes back to it."""
    _holders.add((object_name, who))


def let_go(object_name: str, who: str) -> None:
    _holders.discard((object_name, who))


def _is_held(object_name: str) -> bool:
    return any(name == object_name for name, _ in _holders)


def drop(object_name: str) -> None:
    """Forgets the session, which may still be in use elsewhere; its readout stays for the panel."""
    _bound.pop(object_name, None)


def drop_idle(object_name: str) -> None:
    """Gives back the memory of a session that nobody uses, unless it is held."""
    if not _is_held(object_name):
        _give_back([object_name])


def _give_back(object_names: Iterable[str]) -> None:
    n_gone = 0
    for name in object_names:
        if name in _bound:
            n_gone += _bound.pop(name).inputs.counts[0]
    if n_gone >= LARGE_VERTICES:
        _trim()


def _trim() -> None:
    """Gives freed memory back. The C library of Linux keeps it for the process; those of other systems do not."""
    if sys.platform == "linux":
        malloc_trim = getattr(ctypes.CDLL(None), "malloc_trim", None)  # only glibc has it
        if malloc_trim is not None:
            malloc_trim(0)


def forget_missing(is_there: Callable[[str], bool]) -> None:
    """Forgets sessions and readouts of objects that are gone or renamed: another one may get the name."""
    gone = [name for name in {*_bound, *_readouts} if not is_there(name)]
    _give_back(gone)
    for name in gone:
        _readouts.pop(name, None)
    _holders.difference_update([holder for holder in _holders if not is_there(holder[0])])


def clear() -> None:
    """Forgets everything: another file was loaded."""
    _give_back(list(_bound))
    _holders.clear()
    _readouts.clear()
    acts.clear()


def check_free(object_name: str) -> None:
    """Raises RuntimeError if an act has the mesh for itself."""
    if object_name in acts:
        raise RuntimeError(f"Wait for '{object_name}': {acts[object_name].doing}")


def claim(object_name: str, act: Act) -> None:
    """The act has the mesh for itself from now on, until release(): Live waits. Raises as check_free()."""
    check_free(object_name)
    acts[object_name] = act


def release(object_name: str, act: Act) -> None:
    """Does nothing if the act does not have the mesh, as after another file was loaded."""
    if acts.get(object_name) is act:
        del acts[object_name]


def claimed_by(object_name: str) -> str:
    """What is done with the mesh, '' if no act has it for itself."""
    return acts[object_name].doing if object_name in acts else ""


def readout(object_name: str) -> Readout | None:
    return _readouts.get(object_name)


def set_readout(object_name: str, value: Readout) -> None:
    _readouts[object_name] = value


def build(inputs: SessionInput) -> Steps[AnySession]:
    """Binds and factorizes. Touches no Blender data.

    Raises:
        ValueError: the mesh or its cage cannot be used. RuntimeError: no native module, or the solver failed.
    """
    if inputs.cage is not None:
        module, mesh = native.load(), inputs.mesh
        bind = CageSession.bind(module, mesh, inputs.stretch, inputs.settings, inputs.cage, inputs.mirrors)
        return (yield from bind)
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


def rebuild(inputs: SessionInput, former: Bound | None) -> Steps[AnySession]:
    """build(), or the former session with the handles of ``inputs`` if its bind fits.

    Meanwhile the former one is busy, so it must not be the object's live session. It is as it was if this raises or is
    dropped.

    Raises:
        As build().
    """
    if former is None or difference_of_bind(former.inputs, inputs):
        return (yield from build(inputs))
    if isinstance(former.session, Session):
        yield from former.session.set_handles(inputs.specs, inputs.shown)
    former.session.settings = inputs.settings
    return former.session
