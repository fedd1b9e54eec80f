# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes come back as they were put in, from memory and from the disk."""

import numpy as np
import pytest
from arap_deform import shape_store
from arap_deform.shape_store import ShapeStore


@pytest.mark.parametrize("limit", [1, 200, 10_000_000])
def test_shapes_come_back(monkeypatch, limit):
    monkeypatch.setattr(shape_store, "BYTES_IN_MEMORY", limit)
    shapes = np.random.default_rng(1).normal(size=(9, 5, 3)).astype(np.float32)
    store = ShapeStore(5)
    buffer = np.empty((5, 3), dtype=np.float32)
    for shape in shapes:
        buffer[...] = shape  # the solver's own array is written over by the next solve
        store.append(buffer)
        np.testing.assert_array_equal(store[len(store) - 1], shape)
    assert len(store) == 9
    for index in (8, 0, 4, 4):
        np.testing.assert_array_equal(store[index], shapes[index])
    with pytest.raises(IndexError):
        store[9]
    store.close()
    assert len(store) == 0


def test_a_full_disk_is_said():
    store = ShapeStore(5)

    class Full:
        def seek(self, _):
            pass

        def write(self, _):
            raise OSError(28, "No space left on device")

    store.close()
    store._file = Full()
    message = (
        r"^The solved shapes do not fit into the folder for temporary files \(No space left on device\): "
        r"make room there, or bake fewer frames at once$"
    )
    with pytest.raises(RuntimeError, match=message):
        store.append(np.zeros((5, 3), dtype=np.float32))
