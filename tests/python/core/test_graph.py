# SPDX-License-Identifier: GPL-3.0-or-later
"""What is joined to what."""

import numpy as np
from arap_deform.core.graph import connected_labels, face_edges


def test_connected_labels_agree_with_the_plain_way():
    rng = np.random.default_rng(1)
    n = 200
    first, second = rng.integers(0, n, size=(2, 150)).astype(np.int32)
    expected = np.arange(n)
    for _ in range(n):
        for a, b in zip(first, second, strict=True):
            expected[[a, b]] = expected[[a, b]].min()
    assert np.array_equal(connected_labels(n, first, second), expected)
    path = np.arange(n - 1, dtype=np.int32)
    shuffled = rng.permutation(n).astype(np.int32)
    assert not connected_labels(n, shuffled[path], shuffled[path + 1]).any()


def test_face_edges_close_every_face():
    first, second = face_edges(np.array([0, 1, 2, 2, 1, 4, 3], np.int32), np.array([3, 4], np.int32))
    assert list(zip(first.tolist(), second.tolist(), strict=True)) == [
        (0, 1), (1, 2), (2, 0), (2, 1), (1, 4), (4, 3), (3, 2),
    ]  # fmt: skip
