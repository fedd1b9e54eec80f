# SPDX-License-Identifier: GPL-3.0-or-later
"""An attached object bound to its host: positions of the one in, positions of the other out. No bpy.

Both are in their own spaces. The library works in the solver space of the host, see SolverSpace: so what
turns, turns as seen.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Float32s, Floats, check_places
from ..background import Steps, part, stage
from ..mirror import are_same
from ..session_input import is_same_stretch
from ..transforms import inverted, map_points, transformed
from .probe import Probe, probed
from .surface import PreparedSurface, RestSurface
from .wrap_input import WrapInput

if TYPE_CHECKING:
    import arap_native

SURFACE_SHARE = 0.8  # of the work of a bind, if the surface is not prepared yet


class Wrap:
    """Made by bind()."""

    @classmethod
    def bind(cls, native: Any, inputs: WrapInput, prepared: PreparedSurface | None = None) -> Steps[Wrap]:
        """Binds.

        Args:
            native: the module arap_native.
            prepared: shared with other binds; None: nothing else is bound to the surface.

        Raises:
            ValueError: the arrays cannot be used. MemoryError.
        """
        check_places(inputs.points, inputs.name)
        surface, ready = yield from part((prepared or PreparedSurface()).of(native, inputs), 0.0, SURFACE_SHARE)
        job = ready.begin_bind(
            surface.space.to_solver(transformed(inputs.place, inputs.points.astype(np.float64))),
            options=native.WrapOptions(stay_outside=inputs.keeps_distance, threads=inputs.threads),
            piece_of_point=inputs.pieces,
        )
        del ready  # the job has it
        bound = yield from part(stage(job, inputs.if_cancelled), SURFACE_SHARE, 1.0)
        return cls(inputs, surface, bound)

    def __init__(self, inputs: WrapInput, surface: RestSurface, bound: arap_native.WrapDeformation) -> None:
        """For bind()."""
        self._native = bound
        self._surface = surface
        self.signature = inputs.signature
        self.n_vertices = len(surface.rest)
        self.rest = inputs.points
        self.probe = Probe(
            points=self.rest[probed(len(self.rest))],
            surface=surface.rest[probed(self.n_vertices)],
            place=inputs.place,
        )
        back = inverted(inputs.place)
        self._linear: Floats = np.asarray(back[:3, :3] @ surface.space.unstretch, dtype=np.float64)
        self._shift: Floats = np.asarray(back[:3, 3], dtype=np.float64)
        # Of single precision a frame allocates nothing. Rigid pieces are small, and would lose digits of their shape
        # where they are far from the origin of their host.
        kind: Any = np.float32 if inputs.pieces is None else np.float64
        self._solved: NDArray[Any] = np.empty(inputs.points.shape, dtype=kind)
        self._mapped: NDArray[Any] = np.empty(inputs.points.shape, dtype=kind)

    def is_of(self, inputs: WrapInput) -> bool:
        """Whether a bind of ``inputs`` would be the same."""
        is_same = self.signature == inputs.signature and are_same(self._surface.mirrors, inputs.mirrors)
        return is_same and self.has_stretch(inputs.stretch)

    def has_stretch(self, stretch: Floats) -> bool:
        """Whether it is bound under this stretch of the host, or one that differs by an even scale."""
        own = self._surface.space.stretch
        return is_same_stretch(own / np.abs(own).max(), stretch / np.abs(stretch).max())

    @property
    def n_points(self) -> int:
        return len(self.rest)

    def carried(self, positions: Float32s) -> Float32s:
        """(n, 3) contiguous float32, where the attached object is, for (m, 3) of the host. Valid until the next call.

        Raises:
            ValueError: positions that are not finite, or a result beyond single precision.
        """
        if self._surface.is_at_rest(positions):
            return self.rest
        surface = self._surface.seen(positions)
        if self._solved.dtype == np.float32:
            self._native.deform(surface, out=self._solved)
        else:
            self._solved = self._native.deform(surface)
        map_points(self._solved, self._linear.astype(self._solved.dtype), self._mapped)
        self._mapped += self._shift.astype(self._solved.dtype)
        return np.asarray(self._mapped, dtype=np.float32)
