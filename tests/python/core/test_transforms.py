# SPDX-License-Identifier: GPL-3.0-or-later
"""A linear map of many points."""

import numpy as np
import pytest
from arap_deform.core.transforms import BLOCK, map_points


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 5])
def test_every_point_is_mapped(n, dtype):
    rng = np.random.default_rng(11)
    points = rng.normal(size=(n, 3)).astype(dtype)
    linear = rng.normal(size=(3, 3)).astype(dtype)
    mapped = np.full_like(points, np.nan)
    map_points(points, linear, mapped)
    np.testing.assert_allclose(mapped, np.einsum("ij,kj->ik", points, linear), rtol=0, atol=16 * np.finfo(dtype).eps)


def test_part_of_an_array_is_written_in_place():
    points = np.arange(6.0).reshape(2, 3)
    table = np.zeros((4, 3))
    map_points(points, 2.0 * np.eye(3), table[1:3])
    np.testing.assert_array_equal(table, [[0, 0, 0], *(2 * points), [0, 0, 0]])


def test_columns_of_an_array_are_refused():
    with pytest.raises(ValueError, match="contiguous"):
        map_points(np.zeros((4, 3)), np.eye(3), np.zeros((4, 5))[:, :3])
