# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes come back as they were put in, from memory and from the disk."""

import numpy as np
import pytest
from arap_deform.bake import store
from arap_deform.bake.store import ShapeStore


@pytest.mark.parametrize("limit", [1, 200, 10_000_000])
def test_shapes_come_back(monkeypatch, limit):
    monkeypatch.setattr(store, "BYTES_IN_MEMORY", limit)
    shapes = np.random.default_rng(1).normal(size=(9, 5, 3)).astype(np.float32)
    kept = ShapeStore(5, 9)
    buffer = np.empty((5, 3), dtype=np.float32)
    for shape in shapes:
        buffer[...] = shape  # the solver's own array is written over by the next solve
        kept.append(buffer)
        np.testing.assert_array_equal(kept[len(kept) - 1], shape)
    assert len(kept) == 9
    for index in (8, 0, 4, 4):
        np.testing.assert_array_equal(kept[index], shapes[index])
    with pytest.raises(IndexError):
        kept[9]
    kept.close()
    assert len(kept) == 0


def test_a_full_disk_is_said():
    kept = ShapeStore(5, 9)

    class Full:
        def seek(self, _):
            pass

        def write(self, _):
            raise OSError(28, "No space left on device")

    kept.close()
    kept._file = Full()
    message = (
        r"^The solved shapes do not fit into the folder for temporary files \(No space left on device\): "
        r"free disk space there, or bake fewer frames at once$"
    )
    with pytest.raises(RuntimeError, match=message):
        kept.append(np.zeros((5, 3), dtype=np.float32))


def test_a_disk_without_room_is_said_before_the_first_shape(small_disk):
    message = (
        r"^The file of the solved shapes takes 72 MB, 71 MB more than \S+ has free: free disk space there, "
        r"or bake fewer frames at once$"
    )
    with pytest.raises(ValueError, match=message):
        ShapeStore(1_000_000, 6)
    ShapeStore(1_000_000, 5).close()  # in memory
