# SPDX-License-Identifier: GPL-3.0-or-later
"""The live sessions by object name, when one no longer fits its scene, and which act has a mesh. No Blender data.

Names, because references to Blender's objects do not survive an undo. They are of objects of this file, so whoever asks
for an object that may be linked, as panels do, asks for its full name.
"""

from __future__ import annotations

import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats
from .session import Session
from .session_data import Readout, SessionMesh, SessionSettings
from .stiffness import StiffGroup
from .targets import HandleSpec

# Single-precision world matrices of a turning object differ by less; a user's change of scale by more.
STRETCH_TOLERANCE = 1e-5

Counts = tuple[int, int, int, int]
Hold = tuple[str, bool]  # a vertex group, and whether its vertices are held exactly


@dataclass(frozen=True)
class MeshSignature:
    """A fingerprint of what a session was bound to."""

    counts: Counts
    topology: int
    rest: int
    properties: int

    @classmethod
    def of(cls, counts: Counts, mesh: SessionMesh, properties: Sequence[NDArray[np.generic] | None]) -> MeshSignature:
        """Args: counts of vertices, edges, corners, faces; stiffness and rigid regions."""
        return cls(
            counts,
            _crc(mesh.corner_vertices, mesh.face_sizes),
            _crc(mesh.rest_positions.astype(np.float32)),
            _crc(*(array for array in properties if array is not None)),
        )


@dataclass(frozen=True)
class SessionInput:
    """Everything a session needs, read from the scene; holds no Blender data, so any thread may use it.

    Attributes:
        holds: of the enabled pins, then of the enabled handles, in the order of ``specs``.
        key_name: the shape key that takes the pose.
    """

    object_name: str
    mesh: SessionMesh
    stretch: Floats
    settings: SessionSettings
    specs: tuple[HandleSpec, ...]
    holds: tuple[Hold, ...]
    signature: MeshSignature
    stiff_groups: tuple[StiffGroup, ...] = ()
    key_name: str = ""
    stiffness: Floats | None = field(default=None, repr=False)
    rigid_regions: NDArray[np.int32] | None = field(default=None, repr=False)


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
"""The acts under way, by name of the object: to be read. claim() and release() change it."""

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
    """Raises RuntimeError where an act has the mesh for itself."""
    if object_name in acts:
        raise RuntimeError(f"Wait for '{object_name}': {acts[object_name].doing}")


def claim(object_name: str, act: Act) -> None:
    """The act has the mesh for itself from now on, until release(): Live waits. Raises as check_free()."""
    check_free(object_name)
    acts[object_name] = act


def release(object_name: str, act: Act) -> None:
    """Does nothing where the act does not have the mesh: another file was loaded, and another act has one of its."""
    if acts.get(object_name) is act:
        del acts[object_name]


def claimed_by(object_name: str) -> str:
    """What is done with the mesh, '' where no act has it for itself."""
    return acts[object_name].doing if object_name in acts else ""


def readout(object_name: str) -> Readout | None:
    return _readouts.get(object_name)


def set_readout(object_name: str, value: Readout) -> None:
    _readouts[object_name] = value


def difference_of_bind(old: SessionInput, new: SessionInput) -> str:
    """Why a session of ``old`` must bind again for ``new``, one sentence; '' where it need not."""
    if old.signature.counts != new.signature.counts:
        return counts_differ(new.object_name, old.signature.counts, new.signature.counts)
    if old.signature.topology != new.signature.topology:
        return f"The faces of '{new.object_name}' have changed"
    if old.signature.rest != new.signature.rest:
        return f"The rest shape of '{new.object_name}' has changed"
    if old.signature.properties != new.signature.properties:
        return stiffness_differs(new.object_name)
    if old.settings.of_bind != new.settings.of_bind:
        return settings_differ(new.object_name)
    if not is_same_stretch(old.stretch, new.stretch):
        return stretch_differs(new.object_name)
    return ""


def counts_differ(name: str, old: Counts, new: Counts) -> str:
    return f"The mesh of '{name}' has changed ({old[0]} vertices and {old[3]} faces, now {new[0]} and {new[3]})"


def settings_differ(name: str) -> str:
    return f"Energy, rigidity, weights, threads or seams of '{name}' have changed"


def stiffness_differs(name: str) -> str:
    return f"The stiffness of '{name}' has changed"


def stretch_differs(name: str) -> str:
    return f"The scale of '{name}' has changed"


def key_differs(name: str) -> str:
    return f"The pose of '{name}' has another shape key now"


def groups_differ(name: str) -> str:
    return f"The pins or handles of '{name}' have changed"


def is_same_stretch(old: Floats, new: Floats) -> bool:
    return bool(np.abs(old - new).max() <= STRETCH_TOLERANCE * np.abs(old).max())


def _crc(*arrays: NDArray[np.generic]) -> int:
    value = 0
    for array in arrays:
        value = zlib.crc32(array.tobytes(), value)
    return value
