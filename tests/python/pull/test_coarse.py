# SPDX-License-Identifier: GPL-3.0-or-later
"""A surface drawn together to a few thousand points."""

import numpy as np
import pytest
import sample_meshes
from arap_deform.core.graph import face_edges
from arap_deform.pull import coarse
from arap_deform.pull.coarse import RestMesh

SHEET = sample_meshes.sheet(121)


def fine_of(points, copies=1):
    edges = np.stack(face_edges(SHEET.corner_vertices, SHEET.face_sizes), axis=1)
    shift = len(SHEET.positions) * np.arange(copies)
    return RestMesh(
        points,
        (edges + shift[:, None, None]).reshape(-1, 2),
        (SHEET.corner_vertices + shift[:, None]).ravel().astype(np.int32),
        np.tile(SHEET.face_sizes, copies),
    )


FINE = fine_of(SHEET.positions)


def test_it_has_about_as_many_points_as_it_says_and_the_area_of_the_mesh():
    assert coarse.N_POINTS / 2 < len(FINE.coarse.points) < 1.5 * coarse.N_POINTS
    assert FINE.coarse.areas.sum() == pytest.approx(4.0, rel=0.1)


def test_distances_are_those_along_the_surface():
    exact = np.linalg.norm(FINE.coarse.points - SHEET.positions[0], axis=1)
    assert np.abs(FINE.coarse.distances(np.array([0])) - exact).max() < 0.1


def test_distances_are_found_once_for_a_piece_and_the_oldest_are_forgotten():
    fine = fine_of(SHEET.positions)
    first = fine.coarse.distances(np.array([0]))
    assert fine.coarse.distances(np.array([0])) is first
    points = np.unique(fine.coarse.point_of, return_index=True)[1]
    for vertex in points[-coarse.MOST_KNOWN :]:
        fine.coarse.distances(np.array([vertex]))
    assert len(fine.coarse.known) == coarse.MOST_KNOWN
    again = fine.coarse.distances(np.array([0]))
    assert again is not first
    np.testing.assert_array_equal(again, first)


def test_points_do_not_reach_across_a_gap():
    """Two sheets, one above the other, nearer than the size of a cell."""
    fine = fine_of(np.concatenate([SHEET.positions, SHEET.positions + np.array([0.0, 0.0, 1e-3])]), copies=2)
    n = len(SHEET.positions)
    assert not np.isin(fine.coarse.point_of[:n], fine.coarse.point_of[n:]).any()
    assert np.isinf(fine.coarse.distances(np.array([0]))[fine.coarse.point_of[n:]]).all()


def test_a_small_mesh_stays_as_it_is():
    small = sample_meshes.tube()
    edges = np.stack(face_edges(small.corner_vertices, small.face_sizes), axis=1)
    fine = RestMesh(small.positions, edges, small.corner_vertices, small.face_sizes)
    np.testing.assert_array_equal(fine.coarse.points, small.positions)
