# SPDX-License-Identifier: GPL-3.0-or-later
"""Connects the parts of a shape where they are near each other. No bpy.

A solid has a lattice of its own for each connected part, so parts that are not connected move apart. A bridge is a
triangle without area between two parts. Where it is, the parts have one lattice; rays do not meet it, and it takes
nothing from the look of the surface.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
from numpy.typing import NDArray

from .finer import split_edges
from .shape import Longs, Shape, cells_of, parts_of

EVERYWHERE = 1 / 50  # longest edge, in sizes of the shape: a cube of a solid is no larger
AT_BRIDGES = 1 / 200  # longest edge where two parts are near each other
TOUCHING = 0.5  # in these longest edges: parts with vertices in a cube of this size meet somewhere
REACH = 1.5  # in the same, size of the cubes in which parts that meet are bridged
WIDENINGS = (1.5, 3.0, 6.0)  # the same for parts that have no bridge yet
MOST_IN_CUBE = 2  # other parts that a part is bridged to in a cube


def connected(shape: Shape, most: int) -> Generator[None, None, Shape]:
    """The shape with bridges, and with vertices between its own where it is coarse. Yields now and then.

    Its vertices stay. ``most``: about so many are enough, so a coarse shape stays coarser.
    """
    size = shape.size
    # With edges as long as this about four times as many vertices cover all, if it is all near other parts, as hair is.
    covered = np.sqrt(shape.area / (2.0 * most))
    fine = max(size * AT_BRIDGES, size / np.sqrt(most), covered)
    shape = split_edges(shape, max(size * EVERYWHERE, fine))
    yield
    shape = split_edges(shape, fine, lambda now: _are_near_others(now, 2.0 * fine))
    yield
    # Two fingers that are parts of their own are near each other, but do not meet: they stay free.
    parts = parts_of(shape)
    touching = np.unique(_keys(parts, _pairs(shape.points, parts, TOUCHING * fine)))
    ends = _pairs(shape.points, parts, REACH * fine)
    shape = _with_bridges(shape, ends[np.isin(_keys(parts, ends), touching)])
    for widening in WIDENINGS:
        yield
        shape = _with_bridges(shape, _pairs(shape.points, parts_of(shape), widening * fine))
    return shape


def _are_near_others(shape: Shape, reach: float) -> NDArray[np.bool_]:
    """(n,) whether another part has a vertex in the same cube, of two lattices of cubes of this size."""
    parts = parts_of(shape)
    result = np.zeros(len(parts), dtype=bool)
    for shift in (0.0, 0.5):
        cells = cells_of(shape.points, reach, shift)
        order, starts, cell_of = _sorted(cells, parts)
        # More than one part in a cell: its number of groups.
        several = np.bincount(cell_of)[cell_of] > 1
        sizes = np.diff(np.append(starts, len(order)))
        result[order] |= np.repeat(several, sizes)
    return result


def _pairs(points: NDArray[np.float64], parts: Longs, reach: float) -> Longs:
    """(k, 2) vertices of two parts in a cube, of two lattices of cubes of this size: one of each part and cube."""
    found = [np.empty((0, 2), dtype=np.int64)]
    for shift in (0.0, 0.5):
        order, starts, cell_of = _sorted(cells_of(points, reach, shift), parts)
        chosen = order[starts]
        for step in range(1, MOST_IN_CUBE + 1):
            is_pair = cell_of[step:] == cell_of[:-step]
            if not is_pair.any():
                break
            found.append(np.stack([chosen[:-step][is_pair], chosen[step:][is_pair]], axis=1))
    return np.unique(np.concatenate(found), axis=0)


def _keys(parts: Longs, ends: Longs) -> Longs:
    """(k,) one number for the two parts of each pair: _pairs() gives the lower part first."""
    return np.asarray(parts[ends[:, 0]] * len(parts) + parts[ends[:, 1]])


def _sorted(cells: Longs, parts: Longs) -> tuple[Longs, Longs, Longs]:
    """Vertices by cube, then by part; where each part begins; (k,) number of its cube."""
    order = np.lexsort((parts, cells))
    is_new_cell = np.diff(cells[order], prepend=-1) != 0
    starts = np.flatnonzero(is_new_cell | (np.diff(parts[order], prepend=-1) != 0))
    return order, starts, (np.cumsum(is_new_cell) - 1)[starts]


def _with_bridges(shape: Shape, ends: Longs) -> Shape:
    middles = len(shape.points) + np.arange(len(ends))
    return Shape(
        np.concatenate([shape.points, shape.points[ends].mean(axis=1)]),
        np.concatenate([shape.triangles, np.column_stack([ends, middles])]),
        np.concatenate([shape.weights, shape.weights[:, ends].min(axis=2)], axis=1),
    )
