# SPDX-License-Identifier: GPL-3.0-or-later
"""Loose pieces that move along as rigid bodies: in each pose with the motion that fits what they follow best."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats, Ints
from ..graph import fans
from ..transforms import fitted_rotations
from .pieces import Pieces
from .search import LooseParents, search


class LooseBinding:
    """The pieces that follow, in groups that move as one body each.

    Attributes:
        vertices: (k,) of them.
    """

    def __init__(self, pieces: Pieces, found: LooseParents, images: Sequence[NDArray[np.integer]]) -> None:
        """``images``: see bind_loose_parts()."""
        leader = np.append(found.leader, -1)[pieces.of_vertex]
        self.vertices: NDArray[np.int64] = np.flatnonzero(leader >= 0)
        leaders, self._group_of = np.unique(leader[self.vertices], return_inverse=True)
        group, self._anchors, weights = _anchors(pieces, found, leaders, images)
        self._starts = np.flatnonzero(np.diff(group, prepend=-1))
        weights /= np.add.reduceat(weights, self._starts)[group]
        # The mesh shows single precision, also at rest: a fit to the same numbers moves nothing.
        self._rest = pieces.points.astype(np.float32)
        anchors = self._rest[self._anchors].astype(np.float64)
        centres = np.add.reduceat(weights[:, None] * anchors, self._starts)
        self._coefficients = weights[:, None] * np.column_stack([np.ones(len(group)), anchors - centres[group]])
        self._local = np.empty((len(self.vertices), 3))
        self.start_from(None)

    def start_from(self, positions: NDArray[np.floating] | None) -> None:
        """Keeps each piece as it is in (n, 3) ``positions``: it is there whenever what it follows is as it is there.

        None: as at rest.
        """
        if positions is None:
            positions = self._rest
        rotations, centres = self._motions(positions)
        offsets = positions[self.vertices] - centres[self._group_of]
        self._local = np.einsum("kji,kj->ki", rotations[self._group_of], offsets)

    def move(self, positions: NDArray[np.floating]) -> None:
        """Moves the pieces in (n, 3) ``positions`` after the others."""
        rotations, centres = self._motions(positions)
        moved = np.einsum("kij,kj->ki", rotations[self._group_of], self._local)
        positions[self.vertices] = moved + centres[self._group_of]

    def _motions(self, positions: NDArray[np.floating]) -> tuple[Floats, Floats]:
        """(g, 3, 3) rotations since rest and (g, 3) centres of what the groups follow, for (n, 3) ``positions``."""
        anchors = positions[self._anchors].astype(np.float64)
        products = self._coefficients[:, :, None] * anchors[:, None, :]
        sums = np.add.reduceat(products.reshape(-1, 12), self._starts).reshape(-1, 4, 3)
        return fitted_rotations(sums[:, 1:].transpose(0, 2, 1)), sums[:, 0]


def bind_loose_parts(
    points: Floats,
    corner_vertices: Ints,
    face_sizes: Ints,
    of_vertex: NDArray[np.integer],
    is_held: NDArray[np.bool_],
    images: Sequence[NDArray[np.integer]] = (),
) -> LooseBinding | None:
    """The loose pieces that follow what they sit in; None if there are none.

    Args:
        points: (n, 3) the mesh at rest, as seen.
        corner_vertices, face_sizes: its faces.
        of_vertex: (n,) numbers of its connected pieces, see pieces.numbered().
        is_held: (p,) which of these have a pin or a handle.
        images: (n,) each, vertices at the mirror images of all vertices.
    """
    if is_held.all():
        return None
    pieces = Pieces.of(points, of_vertex)
    starts = np.cumsum(face_sizes, dtype=np.int64) - face_sizes
    found = search(pieces, fans(corner_vertices, starts, face_sizes), is_held, _planes(pieces, images))
    return None if found is None or not (found.leader >= 0).any() else LooseBinding(pieces, found, images)


def _planes(pieces: Pieces, images: Sequence[NDArray[np.integer]]) -> NDArray[np.int64]:
    """(p,) a bit for each of the mirror images that is the piece itself."""
    planes = np.zeros(len(pieces.size), dtype=np.int64)
    for bit, image in enumerate(images):
        is_itself = pieces.of_vertex[image[pieces.first_vertex]] == np.arange(len(planes))
        planes |= is_itself.astype(np.int64) << bit
    return planes


def _anchors(
    pieces: Pieces, found: LooseParents, leaders: NDArray[np.int64], images: Sequence[NDArray[np.integer]]
) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """Groups, vertices and weights of what they follow, in order of the groups; each vertex once in a group.

    What is its own mirror image follows what is as well, so it stays on the plane.
    """
    of_sample = np.searchsorted(leaders, found.pieces)
    group = [np.repeat(of_sample, 3)]
    vertex = [found.samples.corners.ravel().astype(np.int64)]
    weight = [(found.weights[:, None] * found.samples.shares).ravel()]
    planes = _planes(pieces, images)[leaders]
    for bit, image in enumerate(images):
        is_symmetric = (planes[group[0]] >> bit & 1).astype(bool)
        group.append(group[0][is_symmetric])
        vertex.append(image[vertex[0][is_symmetric]].astype(np.int64))
        weight.append(weight[0][is_symmetric])
    n = len(pieces.of_vertex)
    keys, entry = np.unique(np.concatenate(group) * n + np.concatenate(vertex), return_inverse=True)
    total = np.bincount(entry.ravel(), np.concatenate(weight)).astype(np.float64)
    return keys // n, keys % n, total
