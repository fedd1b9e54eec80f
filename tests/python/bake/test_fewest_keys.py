# SPDX-License-Identifier: GPL-3.0-or-later
"""The fewest keys: within the tolerance in every vertex of every frame, and fewer are not possible."""

import itertools

import numpy as np
import pytest
from arap_deform.bake.fewest_keys import KeySearch, possible_pairs, shortest_way


def search(frames, tolerance, times=None, metric=None):
    times = range(len(frames)) if times is None else times
    found = KeySearch(frames, times, tolerance, metric)
    while found.step(10.0):
        pass
    return found


def distances(frames, keys, times=None, metric=None):
    """(f,) largest distance of each frame from the blend of the keys around it, the plain way."""
    times = np.arange(len(frames)) if times is None else np.asarray(times)
    metric = np.eye(3) if metric is None else metric
    result = np.zeros(len(frames))
    for start, end in itertools.pairwise(keys):
        for i in range(start + 1, end):
            share = (times[i] - times[start]) / (times[end] - times[start])
            blend = (1.0 - share) * frames[start].astype(float) + share * frames[end].astype(float)
            result[i] = np.linalg.norm((frames[i].astype(float) - blend) @ metric.T, axis=1).max()
    return result


def fewest_by_trying(frames, tolerance):
    """How many keys are needed, by trying all choices."""
    n = len(frames)
    for k in range(n - 1):
        for inner in itertools.combinations(range(1, n - 1), k):
            if distances(frames, [0, *inner, n - 1]).max() <= tolerance:
                return k + 2
    return n


def wavy(n_frames, n_vertices=40, seed=1):
    """Smooth motions of different speeds."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 1.0, n_frames)[:, None, None]
    phase, speed, size = (rng.uniform(0.2, 1.0, (1, n_vertices, 3)) for _ in range(3))
    return (size * np.sin(6.0 * speed * t + 6.0 * phase)).astype(np.float32)


def test_straight_motions_need_their_ends_alone():
    rng = np.random.default_rng(1)
    start, velocity = rng.normal(size=(2, 50, 3))
    frames = np.array([start + t * velocity for t in range(30)], dtype=np.float32)
    found = search(frames, 1e-4)
    assert found.keys == [0, 29]
    assert found.largest_distance == pytest.approx(distances(frames, [0, 29]).max())


def test_a_corner_is_a_key():
    frames = np.zeros((21, 5, 3), dtype=np.float32)
    frames[:, 2, 0] = np.abs(np.arange(21) - 8)
    assert search(frames, 1e-3).keys == [0, 8, 20]


def test_one_vertex_in_one_frame_counts():
    """Wherever it is: nothing is only sampled."""
    frames = np.zeros((40, 2000, 3), dtype=np.float32)
    frames[17, 1234, 1] = 0.5
    found = search(frames, 0.1)
    assert found.largest_distance <= 0.1
    assert len(found.keys) > 2
    assert distances(frames, found.keys).max() <= 0.1


@pytest.mark.parametrize("tolerance", [0.003, 0.02, 0.1, 0.5])
def test_every_frame_is_within_the_tolerance(tolerance):
    frames = wavy(60)
    found = search(frames, tolerance)
    largest = distances(frames, found.keys).max()
    assert largest <= tolerance * (1.0 + 1e-6)
    assert found.largest_distance == pytest.approx(largest, rel=1e-6)
    assert found.keys[0] == 0
    assert found.keys[-1] == 59
    assert found.keys == sorted(set(found.keys))


@pytest.mark.parametrize("seed", range(12))
def test_fewer_keys_are_not_possible(seed):
    rng = np.random.default_rng(seed)
    frames = (wavy(11, 6, seed) + rng.normal(size=(11, 6, 3), scale=0.02)).astype(np.float32)
    for tolerance in (0.0, 0.02, 0.08, 0.3):
        assert len(search(frames, tolerance).keys) == fewest_by_trying(frames, tolerance)


def test_uneven_times_are_blended_by_time():
    """What is straight in time is straight, whatever the gaps."""
    times = [1, 2, 4, 5, 9, 10]
    frames = np.array([np.full((3, 3), 0.5 * t) for t in times], dtype=np.float32)
    assert search(frames, 1e-5, times).keys == [0, 5]
    assert len(search(frames, 1e-5).keys) > 2


def test_distances_are_measured_as_seen():
    frames = wavy(40, seed=5)
    metric = np.array([[3.0, 0.2, 0.0], [0.2, 1.0, 0.0], [0.0, 0.0, 0.5]])
    seen = (frames @ metric.T).astype(np.float32)
    found = search(frames, 0.05, metric=metric)
    assert distances(frames, found.keys, metric=metric).max() <= 0.05 * (1.0 + 1e-6)
    assert len(found.keys) == len(search(seen, 0.05).keys)


@pytest.mark.parametrize("n", [1, 2])
def test_one_or_two_frames_are_all_keys(n):
    assert search(wavy(n), 10.0).keys == list(range(n))


def test_the_search_goes_in_steps():
    found = KeySearch(wavy(40), range(40), 0.05)
    n_steps = 0
    while found.step(0.0):
        n_steps += 1
        assert found.keys == list(range(40))
    assert n_steps > 40
    assert len(found.keys) < 40
    assert not found.step(0.0)


def test_frames_are_read_one_at_a_time():
    """Three at most are held: a long shot does not fit into memory."""

    class OneAtATime(list):
        def __getitem__(self, index):
            assert isinstance(index, int)
            return super().__getitem__(index).copy()

        def __iter__(self):
            raise AssertionError("all of them")

    frames = wavy(30)
    assert search(OneAtATime(frames), 0.05).keys == search(frames, 0.05).keys


def test_pairs_that_are_ruled_out_are_impossible():
    """The box may let a pair through that a closer look refuses, never the other way round."""
    frames = wavy(30, 8, seed=9).astype(float)
    tolerance = 0.05
    possible = possible_pairs(frames, np.arange(30.0), tolerance)
    n_refused = 0
    for start, end in itertools.combinations(range(30), 2):
        largest = distances(frames, [start, end]).max()
        assert possible[start, end] or largest > tolerance
        n_refused += not possible[start, end]
    assert n_refused > 100


def test_the_shortest_way():
    possible = np.zeros((6, 6), dtype=bool)
    for pair in ((0, 1), (1, 2), (2, 3), (3, 4), (4, 5), (0, 3), (1, 4)):
        possible[pair] = True
    assert shortest_way(possible) in ([(0, 1), (1, 4), (4, 5)], [(0, 3), (3, 4), (4, 5)])
