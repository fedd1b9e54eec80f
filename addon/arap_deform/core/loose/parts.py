# SPDX-License-Identifier: GPL-3.0-or-later
"""The loose parts of a bound mesh: those that the solver leaves at rest, and which of them go along with others."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats, Ints
from ..patches import Surface
from .binding import LooseBinding, bind_loose_parts
from .pieces import joined_by_regions


class LooseParts:
    """Looks again for what moves along only when other parts are loose."""

    def __init__(
        self,
        surface: Surface,
        part_of_vertex: Ints,
        rigid_regions: Ints | None,
        images: Sequence[NDArray[np.integer]],
    ) -> None:
        """``part_of_vertex``: of the solver, -1 for vertices in no face. ``images``: see bind_loose_parts()."""
        self._surface = surface
        self._part_of_vertex = part_of_vertex
        self._piece_of_vertex = joined_by_regions(part_of_vertex, rigid_regions)
        self._images = images
        self._start: Floats | None = None
        self._at_rest: Ints = np.empty(0, dtype=np.int32)
        self._binding: LooseBinding | None = None
        self._riding: Ints = np.empty(0, dtype=np.int32)
        self._staying: NDArray[np.int64] = np.empty(0, dtype=np.int64)

    def start_from(self, positions: Floats | None) -> None:
        """Loose parts go on from (n, 3) ``positions``, as seen, or stay there; None: from rest."""
        self._start = positions
        if self._binding is not None:
            self._binding.start_from(positions)

    def move(self, positions: NDArray[np.float32], at_rest: Ints) -> Ints:
        """Moves the parts that go along in (n, 3) ``positions``, as seen. Returns their numbers.

        Args:
            at_rest: the parts that the solver has left at rest.
        """
        if not np.array_equal(at_rest, self._at_rest):
            self._find(at_rest)
        if self._start is not None:
            positions[self._staying] = self._start[self._staying]
        if self._binding is not None:
            self._binding.move(positions)
        return self._riding

    def _find(self, at_rest: Ints) -> None:
        is_at_rest = np.isin(self._part_of_vertex, at_rest)
        is_held = np.ones(int(self._piece_of_vertex.max(initial=-1)) + 1, dtype=bool)
        is_held[self._piece_of_vertex[is_at_rest]] = False
        surface = self._surface
        self._binding = bind_loose_parts(
            surface.seen,
            surface.corner_vertices,
            surface.face_sizes,
            self._piece_of_vertex,
            is_held,
            self._images,
        )
        riding = np.empty(0, dtype=np.int64) if self._binding is None else self._binding.vertices
        self._riding = np.unique(self._part_of_vertex[riding])
        self._staying = np.setdiff1d(np.flatnonzero(is_at_rest), riding)
        self._at_rest = at_rest
        if self._start is not None:
            self.start_from(self._start)
