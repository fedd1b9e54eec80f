# SPDX-License-Identifier: GPL-3.0-or-later
"""The host, at rest: what the wraps that are bound to it share. No bpy."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Float32s
from ..background import Steps, stage
from ..mirror import are_same, completed
from ..transforms import SolverSpace, map_points
from .wrap_input import WrapInput

if TYPE_CHECKING:
    import arap_native

FIRST_LOOK = 1000  # vertices that tell that a mesh is posed, if not only a small part of it is


class RestSurface:
    """The host, at rest and in poses. All its wraps may hold the same one.

    Attributes:
        signature: of the mesh.
        mirrors: planes that complete it.
        space: where the library works.
        rest: (n, 3) float32 in its own space.
    """

    def __init__(self, inputs: WrapInput) -> None:
        mesh = inputs.mesh
        self.signature = mesh.signature
        self.mirrors = inputs.mirrors
        self.space = SolverSpace(inputs.stretch)
        self.rest = mesh.rest_positions.astype(np.float32)
        self._completed, self._whole = completed(mesh, inputs.mirrors, inputs.stretch)
        self._scratch = np.empty_like(self.rest if self.space.is_stretched else self.rest[:0])

    def is_of(self, inputs: WrapInput) -> bool:
        """Whether one of ``inputs`` would be the same."""
        is_same = self.signature == inputs.mesh.signature and are_same(self.mirrors, inputs.mirrors)
        return is_same and np.array_equal(self.space.stretch, inputs.stretch)

    def is_at_rest(self, positions: Float32s) -> bool:
        """A few vertices first: with many small attached objects, to compare all would be much of a frame."""
        step = max(1, len(self.rest) // FIRST_LOOK)
        return np.array_equal(positions[::step], self.rest[::step]) and np.array_equal(positions, self.rest)

    def seen(self, positions: Float32s) -> NDArray[Any]:
        """The surface at these (n, 3), completed and in solver space. Valid until the next call."""
        if self._whole is not None:
            return self.space.to_solver(self._whole.lifted(positions))
        if not self.space.is_stretched:
            return positions
        map_points(positions, self.space.stretch.astype(np.float32), self._scratch)
        return self._scratch

    def begin_prepare(self, native: Any, threads: int) -> arap_native.Job[arap_native.WrapSurface]:
        """Begins to prepare it for binds, once."""
        mesh = self._completed
        del self._completed  # no wrap needs it
        seen = self.space.to_solver(mesh.rest_positions)
        return native.WrapSurface.begin_prepare(  # type: ignore[no-any-return]
            seen, mesh.corner_vertices, mesh.face_sizes, threads=threads
        )


class PreparedSurface:
    """The surface that was prepared last, kept for the binds that follow until drop(): it may be large."""

    def __init__(self) -> None:
        self._kept: tuple[RestSurface, arap_native.WrapSurface] | None = None

    def drop(self) -> None:
        """The next bind prepares its surface."""
        self._kept = None

    def of(self, native: Any, inputs: WrapInput) -> Steps[tuple[RestSurface, arap_native.WrapSurface]]:
        """The host, and made ready for binds: what is kept, or prepared now."""
        if self._kept is None or not self._kept[0].is_of(inputs):
            self._kept = None  # never two in memory
            surface = RestSurface(inputs)
            job = surface.begin_prepare(native, inputs.threads)
            prepared = yield from stage(job, inputs.if_cancelled)
            self._kept = surface, prepared
        return self._kept
