# SPDX-License-Identifier: GPL-3.0-or-later
"""The live sessions by object name: how one is made, which act has a mesh, what the last solve did. No Blender data.

They are kept by name because references to Blender's objects do not survive an undo. The names are of objects of this
file. So a caller with an object that may be linked, as panels have, asks for its full name.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from . import native
from .background import Steps, part
from .session import Session
from .session_data import Readout
from .session_input import SessionInput, difference_of_bind


@dataclass
class Bound:
    """A session and what it was made from."""

    session: Session
    inputs: SessionInput


class Act(Protocol):
    """Something that has a mesh for itself."""

    @property
    def doing(self) -> str:
        """What goes on: 'it is baked', for example."""


acts: dict[str, Act] = {}
"""The acts under way, by name of the object. Read it; only claim() and release() change it."""

_bound: dict[str, Bound] = {}
_readouts: dict[str, Readout] = {}


def get(object_name: str) -> Bound | None:
    return _bound.get(object_name)


def put(object_name: str, bound: Bound) -> None:
    _bound[object_name] = bound


def drop(object_name: str) -> None:
    """Forgets the session; its readout stays for the panel."""
    _bound.pop(object_name, None)


def forget_missing(is_there: Callable[[str], bool]) -> None:
    """Forgets sessions and readouts of objects that are gone or renamed: another one may get the name."""
    for name in [name for name in {*_bound, *_readouts} if not is_there(name)]:
        _bound.pop(name, None)
        _readouts.pop(name, None)


def clear() -> None:
    """Forgets everything: another file was loaded."""
    _bound.clear()
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
    )
    session = yield from part(binding, 0.0, 0.5)
    yield from part(session.set_handles(inputs.specs), 0.5, 1.0)
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
    yield from former.session.set_handles(inputs.specs)
    former.session.settings = inputs.settings
    return former.session
