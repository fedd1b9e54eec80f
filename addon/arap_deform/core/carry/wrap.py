# SPDX-License-Identifier: GPL-3.0-or-later
"""A follower bound to the mesh that carries it: positions of the one in, positions of the other out. No bpy.

Both are in their own spaces. The library works in the solver space of the mesh that carries, see SolverSpace: so what
turns, turns as seen.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Float32s, Floats, Ints, check_places
from ..background import Steps, stage
from ..mirror import Mirror, are_same, completed
from ..session_data import SessionMesh
from ..session_input import is_same_stretch
from ..transforms import SolverSpace, map_points, transformed
from .probe import Probe, probed

if TYPE_CHECKING:
    import arap_native

FIRST_LOOK = 1000  # vertices that tell that a mesh is posed, if not only a small part of it is


@dataclass(frozen=True, kw_only=True)
class WrapInput:
    """What a wrap is made from. No Blender data.

    Attributes:
        name: of the follower, for messages.
        mesh: what carries, at rest, in its own space.
        stretch: (3, 3) of what carries, see transforms.stretch_of().
        mirrors: planes that complete what carries.
        points: (n, 3) float32 the follower at rest, in its own space.
        place: (4, 4) from there to the space of what carries.
        pieces: (n,) pieces that stay rigid; None: all bends.
        keeps_distance: near points keep their distance from the faces. Off: they follow them smoothly.
        threads: of the library; 0: as many as pay.
    """

    name: str
    mesh: SessionMesh
    stretch: Floats
    mirrors: Sequence[Mirror] = ()
    points: Float32s
    place: Floats
    pieces: Ints | None = None
    keeps_distance: bool = True
    threads: int = 0

    @property
    def signature(self) -> int:
        """A fingerprint of the arrays: another one needs another bind, see also Wrap.is_of()."""
        pieces = np.zeros(0, dtype=np.int32) if self.pieces is None else self.pieces
        value = self.mesh.signature
        for array in (self.place, self.points, pieces):
            value = zlib.crc32(np.ascontiguousarray(array).tobytes(), value)
        return value


class Wrap:
    """Made by bind()."""

    @classmethod
    def bind(cls, native: Any, inputs: WrapInput) -> Steps[Wrap]:
        """Binds.

        Args:
            native: the module arap_native.

        Raises:
            ValueError: the arrays cannot be used. MemoryError.
        """
        check_places(inputs.points, inputs.name)
        wrap = cls(inputs)
        mesh, wrap._whole = completed(inputs.mesh, inputs.mirrors, inputs.stretch)
        seen = wrap._space.to_solver(mesh.rest_positions)
        points = wrap._space.to_solver(transformed(inputs.place, inputs.points.astype(np.float64)))
        job = native.WrapDeformation.begin_bind(
            points,
            seen,
            mesh.corner_vertices,
            mesh.face_sizes,
            native.WrapOptions(stay_outside=inputs.keeps_distance, threads=inputs.threads),
            piece_of_point=inputs.pieces,
        )
        wrap._native = yield from stage(job, f"Preparing '{inputs.name}' was cancelled; nothing has changed")
        return wrap

    def __init__(self, inputs: WrapInput) -> None:
        """Prepares it, for bind()."""
        self._native: arap_native.WrapDeformation
        self._space = SolverSpace(inputs.stretch)
        self._whole: Any = None
        self._mirrors = inputs.mirrors
        self.signature = inputs.signature
        self.n_vertices = len(inputs.mesh.rest_positions)
        self.rest = inputs.points
        self._rest_of_mesh = inputs.mesh.rest_positions.astype(np.float32)
        self.probe = Probe(
            points=self.rest[probed(len(self.rest))],
            surface=self._rest_of_mesh[probed(self.n_vertices)],
            place=inputs.place,
        )
        back = np.linalg.inv(inputs.place)
        self._linear: Floats = np.asarray(back[:3, :3] @ self._space.unstretch, dtype=np.float64)
        self._shift: Floats = np.asarray(back[:3, 3], dtype=np.float64)
        # Of single precision a frame allocates nothing. Rigid pieces are small, and would lose digits of their shape
        # where they are far from the origin of what carries them.
        kind: Any = np.float32 if inputs.pieces is None else np.float64
        self._solved: NDArray[Any] = np.empty(inputs.points.shape, dtype=kind)
        self._mapped: NDArray[Any] = np.empty(inputs.points.shape, dtype=kind)
        self._surface = np.empty_like(self._rest_of_mesh if self._space.is_stretched else self._rest_of_mesh[:0])

    def is_of(self, inputs: WrapInput) -> bool:
        """Whether a bind of ``inputs`` would be the same."""
        is_same = self.signature == inputs.signature and are_same(self._mirrors, inputs.mirrors)
        return is_same and self.has_stretch(inputs.stretch)

    def has_stretch(self, stretch: Floats) -> bool:
        """Whether it is bound under this stretch of what carries, or one that differs by an even scale."""
        own = self._space.stretch
        return is_same_stretch(own / np.abs(own).max(), stretch / np.abs(stretch).max())

    @property
    def n_points(self) -> int:
        return len(self.rest)

    def carried(self, positions: Float32s) -> Float32s:
        """(n, 3) contiguous float32, where the follower is, for (m, 3) of what carries. Valid until the next call.

        Raises:
            ValueError: positions that are not finite, or a result beyond single precision.
        """
        if self._is_at_rest(positions):
            return self.rest
        surface = self._seen(positions)
        if self._solved.dtype == np.float32:
            self._native.deform(surface, out=self._solved)
        else:
            self._solved = self._native.deform(surface)
        map_points(self._solved, self._linear.astype(self._solved.dtype), self._mapped)
        self._mapped += self._shift.astype(self._solved.dtype)
        return np.asarray(self._mapped, dtype=np.float32)

    def _is_at_rest(self, positions: Float32s) -> bool:
        """A few vertices first: with many small followers, to compare all would be much of a frame."""
        step = max(1, self.n_vertices // FIRST_LOOK)
        is_so = np.array_equal(positions[::step], self._rest_of_mesh[::step])
        return is_so and np.array_equal(positions, self._rest_of_mesh)

    def _seen(self, positions: Float32s) -> NDArray[Any]:
        """What carries, completed and in solver space."""
        if self._whole is not None:
            return self._space.to_solver(self._whole.lifted(positions))
        if not self._space.is_stretched:
            return positions
        map_points(positions, self._space.stretch.astype(np.float32), self._surface)
        return self._surface
