# SPDX-License-Identifier: GPL-3.0-or-later
"""The fewest frames whose linear blends keep within a distance of all frames. No bpy.

Which two frames may be neighbours? Those between which no vertex of no frame is further than the tolerance from the
blend of the two. The fewest keys are the shortest way from the first frame to the last over such pairs. To look at
every vertex in every frame for every pair would take hours, so the search knows only some vertices at first, takes
every pair for possible that these do not rule out, and finds the shortest way; then it looks at every vertex, on that
way alone. Where one is too far away, the pair is struck out, the vertex is known from then on, and the search goes on.
What is struck out is impossible indeed, so the way that stands in the end is the shortest of all.
"""

from __future__ import annotations

import time
from collections.abc import Generator, Sequence
from typing import Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Floats

Result = TypeVar("Result")
Steps = Generator[None, None, Result]  # yields between steps, then returns
Pairs = NDArray[np.bool_]  # (f, f) which frames may be neighbours, the earlier one first

SLACK = 1e-6  # of the tolerance: rounding must not rule a pair out that is possible


class Frames(Protocol):
    """All frames; reading one may mean reading a file."""

    def __len__(self) -> int: ...

    def __getitem__(self, index: int) -> NDArray[np.float32]:
        """(n, 3) positions."""


class KeySearch:
    """Searches in steps, so that a window stays alive."""

    def __init__(self, frames: Frames, times: Sequence[float], tolerance: float, metric: Floats | None = None) -> None:
        """Begins.

        Args:
            frames: f of them.
            times: (f,) ascending.
            tolerance: distance, 0 or more.
            metric: (3, 3) distances are measured after it: the stretch of the object; None: as they are.
        """
        self._frames = frames
        self._times = np.asarray(times, dtype=np.float64)
        self._tolerance = tolerance
        self._metric = metric
        self._checked: dict[tuple[int, int], float] = {}
        self._steps = self._search()
        self.keys: list[int] = list(range(len(frames)))
        """Indices of the frames to keep; all of them until the search is done."""
        self.largest_distance = 0.0
        """Of any vertex in any frame from the blend of the keys around it."""

    def step(self, time_limit_s: float) -> bool:
        """Searches for about so long; False once it is done."""
        end = time.perf_counter() + time_limit_s
        return any(time.perf_counter() >= end for _ in self._steps)

    def _search(self) -> Steps[None]:
        if len(self._frames) < 3:
            return
        known: set[int] = set()
        yield from self._learn_from_neighbours(known)
        samples: Floats = np.empty((len(self._frames), 0, 3))
        possible = np.triu(np.ones((len(self._frames),) * 2, dtype=bool), 1)
        fresh = sorted(known)
        while True:
            if fresh:
                more = yield from self._read(fresh)
                possible &= possible_pairs(more, self._times, self._tolerance)
                samples = np.concatenate([samples, more], axis=1)
            way = shortest_way(possible)
            yield
            fresh = []
            struck = [pair for pair in way if not self._is_possible_for(samples, *pair)]
            if not struck:
                found: set[int] = set()
                for pair in way:
                    is_possible = yield from self._check(*pair, found)
                    if not is_possible:
                        struck.append(pair)
                fresh = sorted(found - known)
                known |= found
            if not struck:
                break
            for pair in struck:
                possible[pair] = False
        self.keys = [0, *(end for _, end in way)]
        self.largest_distance = max(self._checked.get(pair, 0.0) for pair in way)

    def _learn_from_neighbours(self, known: set[int]) -> Steps[None]:
        """Finds the vertex of each frame that is furthest from the blend of the frames beside it."""
        before, here = self._frames[0], self._frames[1]
        for i in range(1, len(self._frames) - 1):
            after = self._frames[i + 1]
            known.add(int(self._squares(before, here, after, i - 1, i, i + 1).argmax()))
            before, here = here, after
            yield

    def _read(self, vertices: list[int]) -> Steps[Floats]:
        """Returns (f, k, 3) float64 positions of these vertices in all frames, as measured."""
        result = np.empty((len(self._frames), len(vertices), 3))
        for i in range(len(self._frames)):
            result[i] = self._frames[i][vertices]
            yield
        return result if self._metric is None else result @ self._metric.T

    def _is_possible_for(self, samples: Floats, start: int, end: int) -> bool:
        """Whether the known vertices allow the pair."""
        if end - start < 2:
            return True
        shares = self._share(np.arange(start + 1, end), start, end)[:, None, None]
        off = samples[start + 1 : end] - (1.0 - shares) * samples[start] - shares * samples[end]
        limit = self._tolerance * (1.0 + SLACK)
        return bool((off * off).sum(axis=2).max() <= limit * limit)

    def _check(self, start: int, end: int, found: set[int]) -> Steps[bool]:
        """Returns whether all vertices allow the pair; ``found`` gets the worst one of each frame that does not."""
        if end - start < 2 or (start, end) in self._checked:
            return True
        first, last = self._frames[start], self._frames[end]
        largest = 0.0
        for i in range(start + 1, end):
            squares = self._squares(first, self._frames[i], last, start, i, end)
            worst = int(squares.argmax())
            distance = float(np.sqrt(squares[worst]))
            largest = max(largest, distance)
            if distance > self._tolerance:
                found.add(worst)
            yield
        if largest > self._tolerance:
            return False
        self._checked[start, end] = largest
        return True

    def _squares(
        self,
        first: NDArray[np.float32],
        here: NDArray[np.float32],
        last: NDArray[np.float32],
        start: int,
        index: int,
        end: int,
    ) -> Floats:
        """(n,) squared distances of a frame from the blend of two others."""
        share = float(self._share(index, start, end))
        off = here.astype(np.float64)
        off -= np.multiply(first, 1.0 - share, dtype=np.float64)
        off -= np.multiply(last, share, dtype=np.float64)
        if self._metric is not None:
            off = off @ self._metric.T
        return np.asarray(np.einsum("ij,ij->i", off, off))

    def _share(self, index: int | NDArray[np.intp], start: int, end: int) -> Floats:
        times = self._times
        return np.asarray((times[index] - times[start]) / (times[end] - times[start]))


def possible_pairs(samples: Floats, times: Floats, tolerance: float) -> Pairs:
    """Pairs of frames that these vertices do not rule out, by what can be told in one pass.

    From frame a, the blend up to frame b goes with one velocity (x_b - x_a) / (t_b - t_a) of each vertex. Every frame
    in between allows only velocities in a ball, of radius tolerance / (t - t_a). The box around what is left shrinks
    from frame to frame; the velocity must be in it, and where it is empty no later frame can be a neighbour of a.

    Args:
        samples: (f, k, 3) positions.
        times: (f,) ascending.
        tolerance: distance.
    """
    n = len(samples)
    possible = np.zeros((n, n), dtype=bool)
    lowest, highest = np.full(samples.shape, -np.inf), np.full(samples.shape, np.inf)
    starts: NDArray[np.intp] = np.arange(n)
    for length in range(1, n):
        starts = starts[starts + length < n]
        if not len(starts):
            break
        ends = starts + length
        duration = (times[ends] - times[starts])[:, None, None]
        velocity = (samples[ends] - samples[starts]) / duration
        fits = ((velocity >= lowest[starts]) & (velocity <= highest[starts])).all(axis=(1, 2))
        possible[starts[fits], ends[fits]] = True
        reach = tolerance * (1.0 + SLACK) / duration
        lowest[starts] = np.maximum(lowest[starts], velocity - reach)
        highest[starts] = np.minimum(highest[starts], velocity + reach)
        starts = starts[(lowest[starts] <= highest[starts]).all(axis=(1, 2))]
    return possible


def shortest_way(possible: Pairs) -> list[tuple[int, int]]:
    """The fewest pairs from the first frame to the last, each beginning where the one before ends."""
    n = len(possible)
    n_pairs = np.zeros(n, dtype=np.int64)
    before = np.zeros(n, dtype=np.intp)
    for end in range(1, n):
        starts = np.flatnonzero(possible[:end, end])
        before[end] = starts[n_pairs[starts].argmin()]
        n_pairs[end] = n_pairs[before[end]] + 1
    way: list[tuple[int, int]] = []
    end = n - 1
    while end > 0:
        way.append((int(before[end]), end))
        end = int(before[end])
    return way[::-1]
