# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames, sizes and errors of a bake, as numbers and as text."""

import pytest
from arap_deform.bake.estimate import BakeEstimate, Fit, check_search, frames_of, n_frames


def test_the_last_frame_is_always_baked():
    assert frames_of(1, 10, 4) == [1, 5, 9, 10]
    assert frames_of(-3, 1, 2) == [-3, -1, 1]
    assert frames_of(7, 7, 1) == [7]


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        ((1, 5, 0), "step = 0, must be 1 or more"),
        ((5, 1, 1), "The last frame 1 is before the first, 5: swap them"),
        ((1, 2**31 - 1, 1), "Blender has no frame 2147483647: its frames are -1048574 to 1048574"),
        ((-(10**9), 1, 1), "Blender has no frame -1000000000: its frames are -1048574 to 1048574"),
    ],
)
def test_ranges_without_frames_are_refused(frames, message):
    with pytest.raises(ValueError, match=f"^{message}$"):
        frames_of(*frames)


def test_the_number_of_frames_is_counted_without_a_list_of_them():
    for frames in ((1, 10, 4), (-3, 1, 2), (7, 7, 1), (1, 9, 4)):
        assert n_frames(*frames) == len(frames_of(*frames))
    check_search(10_000)
    with pytest.raises(
        ValueError, match=r"^Fewest Keys takes up to 10000 frames, not 50000: raise Step, or bake in parts$"
    ):
        check_search(50_000)


@pytest.mark.parametrize(
    ("n_keys", "n_vertices", "text"),
    [
        (2, 4, "2 keys, 96 B in the file, 192 B in memory"),
        (48, 136, "48 keys, 78 kB in the file, 157 kB in memory"),
        (1, 1_000_000, "1 key, 12 MB in the file, 24 MB in memory"),
        (250, 1_000_000, "250 keys, 3.0 GB in the file, 6.0 GB in memory"),
    ],
)
def test_estimates(n_keys, n_vertices, text):
    assert str(BakeEstimate(n_keys, n_vertices)) == text


def test_fits():
    assert str(Fit(21, 21, 0.0, 1.0)) == "21 keys"
    assert str(Fit(48, 9, 0.002, 2.0)) == "9 keys for 48 frames, largest error 0.100 % of the size"
