# SPDX-License-Identifier: GPL-3.0-or-later
"""What a session is made from, and why one no longer fits what the scene is now. No Blender data."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .arrays import Float32s, Floats
from .mirror import Mirror, are_same
from .session_data import OF_BIND, SessionMesh, SessionSettings
from .stiffness import StiffGroup
from .targets import HandleSpec

# Single-precision world matrices of a turning object differ by less; a user's change of scale by more.
STRETCH_TOLERANCE = 1e-5

Counts = tuple[int, int, int, int]


@dataclass(frozen=True)
class VertexConstraint:
    """A pin or handle, which constrains the vertices of a vertex group.

    Attributes:
        use_exact, reach: see HandleSpec.
        base_id: a number that changes with its base; 0: the mesh at rest.
    """

    group: str
    use_exact: bool = True
    reach: float = 0.0
    base_id: int = 0


@dataclass(frozen=True)
class BoneConstraint:
    """A bone, which constrains what it passes through.

    Attributes:
        ends: head and tail at rest, object space.
    """

    name: str
    ends: tuple[float, ...]


Constraint = VertexConstraint | BoneConstraint
"""What a control constrains. Another kind is another class here, and a branch in constraints_of() of scene.snapshot and
in spec_of() of scene.inputs."""


@dataclass(frozen=True, kw_only=True)
class SceneState:
    """What a frame compares with the session: all that takes no longer than microseconds to read. No Blender data.

    Attributes:
        counts: of vertices, edges, corners and faces.
        stretch: (3, 3) float64, see transforms.stretch_of().
        constraints: of the enabled controls, in the order of the list.
        key_name: the shape key that takes the pose.
        mirrors: planes of the Mirror modifier that complete the mesh.
    """

    object_name: str
    counts: Counts
    stretch: Floats
    settings: SessionSettings
    constraints: tuple[Constraint, ...]
    stiff_groups: tuple[StiffGroup, ...] = ()
    key_name: str = ""
    mirrors: tuple[Mirror, ...] = ()


@dataclass(frozen=True)
class MeshSignature:
    """A fingerprint of the arrays that a session was bound to."""

    topology: int
    rest: int
    properties: int

    @classmethod
    def of(cls, mesh: SessionMesh, properties: Sequence[NDArray[np.generic] | None]) -> MeshSignature:
        """``properties``: stiffness and rigid regions."""
        return cls(
            _crc(mesh.corner_vertices, mesh.face_sizes),
            _crc(mesh.rest_positions.astype(np.float32)),
            _crc(*(array for array in properties if array is not None)),
        )


@dataclass(frozen=True, kw_only=True)
class SessionInput(SceneState):
    """Everything a session needs, read from the scene. Any thread may use it.

    Attributes:
        specs: in the order of ``holds``.
        shown: (n, 3) the pose that loose pieces go on from; None: rest.
    """

    mesh: SessionMesh
    specs: tuple[HandleSpec, ...]
    signature: MeshSignature
    stiffness: Floats | None = field(default=None, repr=False)
    rigid_regions: NDArray[np.int32] | None = field(default=None, repr=False)
    shown: Float32s | None = field(default=None, repr=False)


def difference_of_bind(old: SessionInput, new: SessionInput) -> str:
    """Why a session of ``old`` must bind again for ``new``, one sentence; '' if it need not."""
    if old.counts != new.counts:
        return counts_differ(new.object_name, old.counts, new.counts)
    if old.signature.topology != new.signature.topology:
        return f"The faces of '{new.object_name}' have changed"
    if old.signature.rest != new.signature.rest:
        return f"The rest shape of '{new.object_name}' has changed"
    if old.signature.properties != new.signature.properties:
        return f"The stiffness of '{new.object_name}' has changed"
    return _difference_of_settings(old, new)


def difference(old: SessionInput, new: SessionInput) -> str:
    """As difference_of_bind(), and both must hold the same vertices in the same way and from the same places."""
    # A pull may hold what handles hold, but not from rest.
    are_same = len(old.specs) == len(new.specs) and all(
        a.is_same_as(b) and a.has_base_of(b) for a, b in zip(old.specs, new.specs, strict=True)
    )
    return difference_of_bind(old, new) or (
        "" if are_same else f"The pins or handles of '{new.object_name}' have changed"
    )


def difference_of_scene(old: SceneState, new: SceneState) -> str:
    """Why a session of ``old`` cannot go on with the scene as it is now, one sentence; '' if it can."""
    if old.key_name != new.key_name:
        return key_differs(new.object_name)  # the pose would show twice, in the former key and in this one
    if old.counts != new.counts:
        return counts_differ(new.object_name, old.counts, new.counts)
    if old.constraints != new.constraints:
        return f"The pins or handles of '{new.object_name}' have changed"
    if old.stiff_groups != new.stiff_groups:
        return f"The stiffness of '{new.object_name}' has changed"
    return _difference_of_settings(old, new)


def _difference_of_settings(old: SceneState, new: SceneState) -> str:
    if (old.mirrors or new.mirrors) and not are_same(old.mirrors, new.mirrors):
        return f"The Mirror modifier of '{new.object_name}' has changed"
    if old.settings != new.settings and old.settings.of_bind != new.settings.of_bind:
        return f"{OF_BIND.replace(' and ', ' or ')} of '{new.object_name}' have changed"
    return "" if is_same_stretch(old.stretch, new.stretch) else f"The scale of '{new.object_name}' has changed"


def counts_differ(name: str, old: Counts, new: Counts) -> str:
    return f"The mesh of '{name}' has changed ({old[0]} vertices and {old[3]} faces, now {new[0]} and {new[3]})"


def key_differs(name: str) -> str:
    return f"The pose of '{name}' has another shape key now"


def is_same_stretch(old: Floats, new: Floats) -> bool:
    return bool(np.abs(old - new).max() <= STRETCH_TOLERANCE * np.abs(old).max())


def _crc(*arrays: NDArray[np.generic]) -> int:
    value = 0
    for array in arrays:
        value = zlib.crc32(array.tobytes(), value)
    return value
