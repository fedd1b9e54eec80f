# SPDX-License-Identifier: GPL-3.0-or-later
"""Strain: mean change of the length of the edges at a vertex, and its colours."""

from __future__ import annotations

import numpy as np
import pytest
from arap_deform.show.strain import LONGER, OPACITY, SAME, SHORTER, EdgeStrain, colors_of

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], dtype=np.float32)
SIDES = np.array([[0, 1], [1, 2], [2, 3], [3, 0]], dtype=np.int32)
NO_STRETCH = np.eye(3)


def test_rest_and_rigid_motions_have_none() -> None:
    strain = EdgeStrain(SQUARE, SIDES, NO_STRETCH)
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]], dtype=np.float32)
    for positions in (SQUARE, SQUARE @ turn.T + np.float32(7.0)):
        np.testing.assert_allclose(strain.of(positions), 0.0, atol=1e-6)


@pytest.mark.parametrize("scale", [0.5, 1.25, 3.0])
def test_a_scaled_mesh_has_the_same_everywhere(scale: float) -> None:
    strain = EdgeStrain(SQUARE, SIDES, NO_STRETCH).of(SQUARE * np.float32(scale))
    assert strain.dtype == np.float32
    np.testing.assert_allclose(strain, scale - 1.0, rtol=1e-6)


def test_it_is_the_mean_over_the_edges_of_a_vertex() -> None:
    wide = SQUARE * np.array([1.5, 1.0, 1.0], dtype=np.float32)
    np.testing.assert_allclose(EdgeStrain(SQUARE, SIDES, NO_STRETCH).of(wide), 0.25, rtol=1e-6)
    lifted = SQUARE.copy()
    lifted[0] = (0.0, -1.0, 0.0)  # side 3-0 is twice as long, side 0-1 by the square root of 2
    expected = [(1.0 + np.sqrt(2) - 1.0) / 2, (np.sqrt(2) - 1.0) / 2, 0.0, 0.5]
    np.testing.assert_allclose(EdgeStrain(SQUARE, SIDES, NO_STRETCH).of(lifted), expected, atol=1e-6)


def test_lengths_are_those_seen_under_the_scale_of_the_object() -> None:
    """Along x everything looks ten times as long: a turn of the long side into y is a change as seen."""
    stretch = np.diag([10.0, 1.0, 1.0])
    edge = np.array([[0, 0, 0], [1, 0, 0]], dtype=np.float32)
    turned = np.array([[0, 0, 0], [0, 1, 0]], dtype=np.float32)
    strain = EdgeStrain(edge, np.array([[0, 1]], dtype=np.int32), stretch)
    np.testing.assert_allclose(strain.of(turned), -0.9, rtol=1e-6)


def test_loose_vertices_and_edges_without_a_length_have_none() -> None:
    rest = np.array([[0, 0, 0], [0, 0, 0], [1, 0, 0], [5, 5, 5]], dtype=np.float32)
    strain = EdgeStrain(rest, np.array([[0, 1], [1, 2]], dtype=np.int32), NO_STRETCH)
    moved = rest + np.array([[3, 0, 0], [0, 0, 0], [1, 0, 0], [9, 9, 9]], dtype=np.float32)
    np.testing.assert_allclose(strain.of(moved), [0.0, 1.0, 1.0, 0.0], atol=1e-6)


def test_a_mesh_without_edges() -> None:
    strain = EdgeStrain(SQUARE, np.empty((0, 2), dtype=np.int32), NO_STRETCH)
    np.testing.assert_array_equal(strain.of(SQUARE), np.zeros(4))


def test_colours_run_from_shorter_over_the_same_to_longer_and_stay_there() -> None:
    colors = colors_of(np.array([-9.0, -0.2, 0.0, 0.2, 9.0], dtype=np.float32), 0.2)
    assert colors.dtype == np.float32
    np.testing.assert_allclose(colors[:, :3], [SHORTER, SHORTER, SAME, LONGER, LONGER], atol=1e-6)
    np.testing.assert_allclose(colors[:, 3], OPACITY)
    half = colors_of(np.array([0.1], dtype=np.float32), 0.2)[0, :3]
    np.testing.assert_allclose(half, (np.array(SAME) + LONGER) / 2, atol=1e-6)
