# SPDX-License-Identifier: GPL-3.0-or-later
"""Which loose pieces go along with what, at rest.

A piece follows the held surface near it: of a larger held piece, and no farther off than its reach, which is a quarter
of its own size, or a small part of the size of what is held. A piece inside a larger loose one that is near a held
piece (a pupil in an eye) goes with that. What is near no held piece goes with the nearest loose piece that follows (a
feather on a hat). A neighbour of about the same size (the next letter of a word) stays.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..arrays import Floats
from .near import Cells
from .pieces import LARGER, Pieces
from .samples import Samples, sample

REACH = 0.25  # of a piece, in its size
LEAST_REACH = 0.005  # in the size of the largest held piece: for buttons
WIDE_REACH = 0.02  # of pieces that would follow nothing else, in the same: for teeth
FINE = 1.0 / 3.0  # between samples of what is followed, in reaches
COARSE = 0.5  # between other samples
MOST_IN_CELL = 256  # samples in a cube of two reaches: about seven walls
MOST_FOLLOWED = 80_000  # samples that all pieces follow, about: a frame of them takes hundredths of a second
LEAST_FOLLOWED = 16  # that each piece may follow, however many pieces there are
QUERIES_AT_ONCE = 4_000  # samples; bounds memory


class Neighbours(NamedTuple):
    """Pairs of a piece and what is near it: (k,) numbers of the pieces, of the others, and their distances."""

    pieces: NDArray[np.int64]
    others: NDArray[np.int64]
    distances: Floats

    def chosen(self, which: NDArray[np.generic]) -> Neighbours:
        return Neighbours(*(column[which] for column in self))

    def nearest(self) -> Neighbours:
        """The nearest of each piece, and of these the first."""
        nearest_first = self.chosen(np.lexsort((self.others, self.distances, self.pieces)))
        return nearest_first.chosen(np.unique(nearest_first.pieces, return_index=True)[1])

    def each_once(self) -> Neighbours:
        """Each pair once, with its least distance."""
        pairs = self.pieces * (int(self.others.max(initial=0)) + 1) + self.others
        order = np.argsort(pairs, kind="stable")
        starts = np.flatnonzero(np.diff(pairs[order], prepend=-1))
        least = np.minimum.reduceat(self.distances[order], starts) if len(starts) else np.empty(0)
        return Neighbours(self.pieces[order[starts]], self.others[order[starts]], least)

    def at_most(self, n: int) -> Neighbours:
        """No more than that of each piece: near ones and far ones alike."""
        ordered = self.chosen(np.lexsort((self.distances, self.pieces)))
        _, first, counts = np.unique(ordered.pieces, return_index=True, return_counts=True)
        place = np.arange(len(ordered.pieces)) - np.repeat(first, counts)
        kept = np.minimum(counts, n)
        is_kept = place * np.repeat(kept, counts) % np.repeat(counts, counts) < np.repeat(kept, counts)
        return ordered.chosen(is_kept)


@dataclass(frozen=True)
class LooseParents:
    """What follows what.

    Attributes:
        leader: (p,) the loose piece with which each one goes, for many itself; -1 for pieces that do not follow.
        pieces, samples, weights: (a,) what each leader follows.
    """

    leader: NDArray[np.int64]
    pieces: NDArray[np.int64]
    samples: Samples
    weights: Floats


def search(
    pieces: Pieces, triangles: NDArray[np.integer], is_held: NDArray[np.bool_], planes: NDArray[np.int64]
) -> LooseParents | None:
    """None if no loose piece is near anything.

    Args:
        triangles: (t, 3) of the mesh.
        is_held: (p,) which pieces have a pin or a handle.
        planes: (p,) a bit for each mirror image that a piece touches: it cannot go with one that leaves such a plane.
    """
    if is_held.all() or not is_held.any():
        return None
    size = float(pieces.size[is_held].max())
    is_loose = ~is_held & pieces.is_near(is_held, size)  # what is very far away would make cells coarse
    if not is_loose.any() or size <= 0.0:
        return None
    reach = np.maximum(REACH * pieces.size, LEAST_REACH * size)
    wide = np.maximum(reach, WIDE_REACH * size)
    spacing = FINE * reach[is_loose].min()
    of_triangle = pieces.of_vertex[triangles[:, 0]]
    is_useful = is_held[of_triangle] & pieces.reach_near(triangles, is_loose, wide[is_loose].max())
    if not is_useful.any():
        return None
    held, free = (
        sample(pieces.points, triangles[rows], of_triangle[rows], spacing).thinned(spacing)
        for rows in (is_useful, is_loose[of_triangle])
    )
    anchors = _followed(free, held, pieces, reach)
    held_size = _held_size(anchors, held, pieces)
    between = _between(free, held_size >= 0.0, pieces.size, reach, planes)
    leader = _leaders(pieces, held_size, between)
    is_left = is_loose & (leader < 0)
    reach[is_left] = wide[is_left]
    anchors = _joined([anchors, _followed(free.chosen(is_left[free.pieces]), held, pieces, reach)])
    leader = _leaders(pieces, _held_size(anchors, held, pieces), between)
    anchors = anchors.chosen(leader[anchors.pieces] == anchors.pieces)
    n_leaders = len(np.unique(anchors.pieces))
    anchors = anchors.at_most(max(LEAST_FOLLOWED, MOST_FOLLOWED // max(n_leaders, 1)))
    weights = (1.0 - anchors.distances / reach[anchors.pieces]) ** 2
    return LooseParents(leader, anchors.pieces, held.chosen(anchors.others), weights)


def _followed(free: Samples, held: Samples, pieces: Pieces, reach: Floats) -> Neighbours:
    """What samples of held pieces each loose piece could follow."""
    return _joined(_to_large(near, held, pieces) for near in _near(free, held, reach, FINE))


def _held_size(anchors: Neighbours, held: Samples, pieces: Pieces) -> Floats:
    """(p,) size of the largest held piece that each loose one could follow; -1 for none."""
    result = np.full(len(pieces.size), -1.0)
    sizes = pieces.size[held.pieces[anchors.others]]
    largest_last = np.argsort(sizes, kind="stable")
    result[anchors.pieces[largest_last]] = sizes[largest_last]
    return result


def _near(free: Samples, others: Samples, reach: Floats, spacing: float) -> Iterator[Neighbours]:
    """What samples are nearer to loose pieces than they reach: pieces, rows of ``others``, distances, each pair once.

    ``spacing``: of ``others``, in reaches.

    Pieces of about the same reach are looked at together, so that a surface has few samples within it.
    """
    yield Neighbours(np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0))
    if not len(others.pieces):
        return
    octave = np.floor(np.log2(reach)).astype(np.int64)
    for level in np.unique(octave[np.unique(free.pieces)]):
        queries = free.chosen(octave[free.pieces] == level)
        largest = float(reach[queries.pieces].max())
        queries = queries.thinned(COARSE * largest)
        queries = queries.chosen(np.argsort(queries.pieces, kind="stable"))
        rows = others.thinned_rows(spacing * largest)
        ends = np.flatnonzero(np.diff(queries.pieces, append=-1)) + 1
        cells = Cells(others.places[rows], largest, MOST_IN_CELL)
        for chunk in _chunks(ends):
            some = queries.chosen(chunk)
            query, found, distances = cells.pairs(some.places)
            near = Neighbours(some.pieces[query], rows[found], distances)
            yield near.chosen(distances < reach[near.pieces]).each_once()


def _chunks(ends: NDArray[np.int64]) -> Iterator[NDArray[np.int64]]:
    """Rows in pieces of about QUERIES_AT_ONCE, cut at some of ``ends``, ascending."""
    start = 0
    while start < ends[-1]:
        end = int(ends[min(int(np.searchsorted(ends, start + QUERIES_AT_ONCE)), len(ends) - 1)])
        yield np.arange(start, end)
        start = end


def _to_large(near: Neighbours, held: Samples, pieces: Pieces) -> Neighbours:
    """Only of held pieces that are much larger, or that have the middle of what would follow them within their box."""
    of_held = held.pieces[near.others]
    is_as_large = pieces.size[of_held] >= pieces.size[near.pieces]
    is_larger = pieces.size[of_held] >= LARGER * pieces.size[near.pieces]
    return near.chosen(is_larger | (is_as_large & pieces.is_middle_inside(near.pieces, of_held)))


def _between(
    free: Samples, is_near: NDArray[np.bool_], size: Floats, reach: Floats, planes: NDArray[np.int64]
) -> Neighbours:
    """Pairs of different loose pieces that are near each other.

    Args:
        is_near: (p,) which pieces are near held ones. They are only looked for inside others.
    """
    of_near = is_near[free.pieces]
    outer = of_near & (size[free.pieces] >= LARGER * size[is_near].min(initial=np.inf))
    parts = []
    for queries, others in ((free.chosen(of_near), free.chosen(outer)), (free.chosen(~of_near), free)):
        for near in _near(queries, others, reach, COARSE):
            pairs = Neighbours(near.pieces, others.pieces[near.others], near.distances)
            leaves_plane = (planes[pairs.pieces] & ~planes[pairs.others]) != 0
            parts.append(pairs.chosen((pairs.pieces != pairs.others) & ~leaves_plane).each_once())
    return _joined(parts)


def _joined(parts: Iterable[Neighbours]) -> Neighbours:
    return Neighbours(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _leaders(pieces: Pieces, held_size: Floats, between: Neighbours) -> NDArray[np.int64]:
    """(p,) see LooseParents."""
    is_near = held_size >= 0.0
    leader = np.where(is_near, np.arange(len(held_size)), -1)
    is_inside = is_near[between.others] & pieces.is_inside(between.pieces, between.others)
    around = between.chosen(is_inside).nearest()
    leader[around.pieces] = around.others  # always a larger one, so there is no circle
    while not np.array_equal(leader, _led(leader, leader)):
        leader = _led(leader, leader)
    while True:
        new = (leader[between.pieces] < 0) & (leader[between.others] >= 0)
        new &= LARGER * pieces.size[between.pieces] <= held_size[leader[between.others]]
        if not new.any():
            return leader
        nearest = between.chosen(new).nearest()
        leader[nearest.pieces] = leader[nearest.others]
        between = between.chosen(leader[between.pieces] < 0)


def _led(leader: NDArray[np.int64], by: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.where(by >= 0, leader[by], -1)
