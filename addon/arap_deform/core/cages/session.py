# SPDX-License-Identifier: GPL-3.0-or-later
"""One mesh bound to a cage: positions of the cage's vertices in, positions of the mesh out."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..arrays import Float32s, Floats
from ..background import Steps, stage
from ..mirror import Mirror
from ..session_data import Readout, SessionMesh, SessionSettings
from ..transforms import SolverSpace, transformed

if TYPE_CHECKING:
    import arap_native


@dataclass(frozen=True, eq=False)
class Cage:
    """A cage, and what hangs on it.

    Attributes:
        name: for messages.
        mesh: the cage at rest, in the space of the mesh inside.
        coordinates: how the mesh hangs on it, see CageOptions of arap_native.
        base: (n, 3) where the vertices of the mesh are while the cage is at rest; None: at rest, too.
    """

    name: str
    mesh: SessionMesh
    coordinates: str
    base: Floats | None = None


class CageSession:
    """Stands for a Session if a cage moves the mesh: whoever follows, solves or bakes takes either. Made by bind()."""

    @classmethod
    def bind(
        cls,
        native: Any,
        mesh: SessionMesh,
        stretch: Floats,
        settings: SessionSettings,
        cage: Cage,
        mirrors: Sequence[Mirror] = (),
    ) -> Steps[CageSession]:
        """Binds.

        Args:
            native: the module arap_native.
            mesh: at rest.
            stretch: (3, 3) symmetric factor of the mesh's matrix: even coordinates are even as seen.
            settings: for the threads.
            cage: what moves it.
            mirrors: planes on which vertices of half a mesh stay, see mirror.used_mirrors().

        Raises:
            ValueError: the cage is not closed, or with "green" and "harmonic" vertices are not inside.
        """
        session = cls(mesh, stretch, settings, mirrors)
        start = time.perf_counter()
        job = native.CageDeformation.begin_bind(
            session._space.to_solver(mesh.rest_positions if cage.base is None else cage.base),
            session._space.to_solver(cage.mesh.rest_positions),
            cage.mesh.corner_vertices,
            cage.mesh.face_sizes,
            options=native.CageOptions(coordinates=cage.coordinates, threads=settings.threads),
        )
        try:
            session._model = yield from stage(job, "Binding was cancelled; nothing has changed")
        except ValueError as error:
            raise ValueError(f"Cage '{cage.name}' cannot move the mesh: {error}") from None
        session._bind_ms = 1e3 * (time.perf_counter() - start)
        return session

    def __init__(
        self, mesh: SessionMesh, stretch: Floats, settings: SessionSettings, mirrors: Sequence[Mirror]
    ) -> None:
        """Prepares it, for bind()."""
        self.mirrors = tuple(mirrors)
        self.settings = settings
        self._space = SolverSpace(stretch)
        self._rest = mesh.rest_positions
        self._on_planes = [(mirror, np.flatnonzero(mirror.sides(self._rest) == 0.0)) for mirror in mirrors]
        self._positions = self._rest.astype(np.float32)
        self._solved = np.empty_like(self._positions)  # solver space; a frame allocates nothing
        self._model: arap_native.CageDeformation
        self._bind_ms = 0.0

    @property
    def n_vertices(self) -> int:
        return len(self._rest)

    @property
    def stretch(self) -> Floats:
        """(3, 3) float64."""
        return self._space.stretch

    @property
    def positions(self) -> Float32s:
        """(n, 3) float32, contiguous, object space: where the mesh is now. Written over by the next update."""
        return self._positions

    def update(self, cage_positions: Floats, /, **_solving: object) -> Readout:
        """Moves the mesh with its cage.

        Args:
            cage_positions: (c, 3) float64 the cage's vertices, object space of the mesh.
            _solving: what Session.update() takes besides. There is nothing to iterate.

        Raises:
            ValueError: wrong shape, not finite, or too far away for single precision; the last also as a RuntimeError.
                The mesh stays where it was.
        """
        start = time.perf_counter()
        self._model.deform(self._space.to_solver(np.asarray(cage_positions, dtype=np.float64)), out=self._solved)
        self._space.show(self._solved, self._positions)
        for mirror, vertices in self._on_planes:
            there = self._positions[vertices].astype(np.float64)
            self._positions[vertices] = 0.5 * (there + transformed(mirror.matrix, there))
        return Readout(
            vertices=self.n_vertices,
            free_vertices=0,
            last_ms=1e3 * (time.perf_counter() - start),
            iterations=0,
            energy=0.0,
            energy_before=0.0,
            step=0.0,
            stop_reason="converged",
            parts_at_rest=0,
            loose_vertices=0,
            outside=(),
            bind_ms=self._bind_ms,
            factor_ms=0.0,
        )

    def updating(self, cage_positions: Floats, /, **solving: object) -> Steps[Readout]:
        """As update(): it takes milliseconds, so it is one step."""
        yield from ()
        return self.update(cage_positions, **solving)

    def set_positions(self, positions: NDArray[np.floating]) -> None:
        """Shows ``positions``, (n, 3), object space, until the next update. Raises ValueError: wrong shape."""
        if positions.shape != (self.n_vertices, 3):
            raise ValueError(f"positions have shape {positions.shape}, expected {(self.n_vertices, 3)}")
        self._positions[...] = positions

    def reset(self) -> None:
        """Shows the mesh at rest until the next update."""
        self._positions[...] = self._rest
