# SPDX-License-Identifier: GPL-3.0-or-later
"""Distances along surfaces with known distances: planes, bent planes, parts that are not joined."""

import numpy as np
import pytest
import sample_meshes
from arap_deform.core.distance import distances_within, faded

N = 41
STEP = 2.0 / (N - 1)


def sheet(cut="quads"):
    """A square 2 wide about the origin, of quads or of triangles: points, corners, sizes."""
    mesh = sample_meshes.sheet(N)
    if cut == "quads":
        return mesh
    triangles = mesh.corner_vertices.reshape(-1, 4)[:, [0, 1, 2, 0, 2, 3]]
    return mesh.positions, triangles.ravel(), np.full(2 * len(triangles), 3, np.int32)


@pytest.mark.parametrize("cut", ["quads", "triangles"])
def test_from_a_straight_edge_it_is_the_distance_from_the_line(cut):
    points, corners, sizes = sheet(cut)
    sources = np.flatnonzero(points[:, 0] <= -0.5).astype(np.int32)
    found = distances_within(points, corners, sizes, sources, 0.7)
    expected = np.maximum(0.0, points[:, 0] - points[sources, 0].max())
    is_within = expected <= 0.7
    np.testing.assert_allclose(found[is_within], expected[is_within], atol=1e-9)
    assert np.isinf(found[~is_within]).all()


def test_from_a_point_it_is_round_and_not_bound_to_the_edges():
    points, corners, sizes = sheet()
    centre = np.array([N * N // 2], np.int32)
    found = distances_within(points, corners, sizes, centre, 0.9)
    expected = np.linalg.norm(points, axis=1)
    is_within = np.isfinite(found)
    assert (found[is_within] >= expected[is_within] - 1e-9).all()
    np.testing.assert_allclose(found[is_within], expected[is_within], atol=0.3 * STEP)
    assert is_within[expected < 0.9 - 0.3 * STEP].all()
    # Along the edges it would be |x| + |y|, 41 percent more on the diagonal.
    corner = np.abs(points[:, 0] - points[:, 1]) + np.abs(points[:, 0] - 0.5)
    assert found[corner.argmin()] < 1.05 * np.sqrt(0.5)


def test_a_bent_sheet_has_the_distances_of_the_flat_one():
    points, corners, sizes = sheet()
    centre = np.array([N * N // 2], np.int32)
    flat = distances_within(points, corners, sizes, centre, 0.8)
    folded = points.copy()
    is_right = points[:, 0] > 0.0
    folded[is_right, 0], folded[is_right, 2] = 0.0, points[is_right, 0]
    np.testing.assert_allclose(distances_within(folded, corners, sizes, centre, 0.8), flat, atol=1e-9)


def test_parts_that_are_not_joined_are_not_reached_however_near():
    points, corners, sizes = sheet()
    n = len(points)
    both = np.concatenate([points, points + np.array([0.0, 0.0, 1e-3])])
    centre = np.array([n // 2], np.int32)
    found = distances_within(
        both, np.concatenate([corners, corners + n]).astype(np.int32), np.tile(sizes, 2), centre, 0.5
    )
    assert np.isfinite(found[:n]).any()
    assert np.isinf(found[n:]).all()


def test_polygons_and_degenerate_faces():
    # A hexagon, and a triangle with two corners at one place.
    angle = np.arange(6) * (np.pi / 3.0)
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(6)])
    points = np.concatenate([ring, [[2.0, 0.0, 0.0], [2.0, 0.0, 0.0]]])
    corners = np.array([0, 1, 2, 3, 4, 5, 0, 6, 7], np.int32)
    found = distances_within(points, corners, np.array([6, 3], np.int32), np.array([0], np.int32), 3.0)
    expected = np.linalg.norm(points - points[0], axis=1)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_no_radius_and_no_faces_near():
    points, corners, sizes = sheet()
    centre = np.array([N * N // 2], np.int32)
    for radius in (0.0, 0.1 * STEP):
        found = distances_within(points, corners, sizes, centre, radius)
        assert found[centre[0]] == 0.0
        assert np.isinf(np.delete(found, centre[0])).all()


def test_weights_fade_smoothly_from_one_to_zero():
    distances = np.linspace(0.0, 2.0, 201)
    weights = faded(distances, 1.0)
    assert weights[0] == 1.0
    assert (weights[distances >= 1.0] == 0.0).all()
    assert (np.diff(weights) <= 0.0).all()
    slope = np.abs(np.diff(weights)) / 0.01
    assert slope[0] < 0.05
    assert slope[99] < 0.05
    np.testing.assert_allclose(faded(np.array([0.5, np.inf]), 1.0), [0.5, 0.0])
    np.testing.assert_array_equal(faded(np.array([0.0, 1e-9]), 0.0), [1.0, 0.0])
