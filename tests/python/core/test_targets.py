# SPDX-License-Identifier: GPL-3.0-or-later
"""Targets of vertices from the matrices of handles."""

import numpy as np
import pytest
from arap_deform.core.targets import HandleMap, HandleSpec, Segment
from arap_deform.core.transforms import nearest_rotations
from sample_meshes import motion, rotation_z

REST = np.random.default_rng(7).normal(size=(12, 3))
STRETCH = np.array([[2.0, 0.3, 0.0], [0.3, 1.0, 0.1], [0.0, 0.1, 0.5]])
NONE = np.eye(4)


def spec(vertices, weights=None, name="Tail"):
    weights = np.ones(len(vertices)) if weights is None else np.array(weights, dtype=float)
    return HandleSpec(name, np.array(vertices, dtype=np.int32), weights)


def moved(matrix, vertices):
    return (REST[vertices] @ matrix[:3, :3].T + matrix[:3, 3]) @ STRETCH.T


def test_targets_are_moved_rest_positions_in_solver_space():
    handle_map = HandleMap([spec([3, 1]), spec([5])], REST, STRETCH)
    turn, shift = motion(rotation_z(0.7)), motion(shift=(1.0, 2.0, 3.0))
    targets = handle_map.targets(np.array([turn, shift]))
    assert handle_map.vertices.tolist() == [3, 1, 5]
    np.testing.assert_allclose(targets[:2], moved(turn, [3, 1]), atol=1e-14)
    np.testing.assert_allclose(targets[2:], moved(shift, [5]), atol=1e-14)


def test_only_a_moved_handle_changes_its_rows():
    handle_map = HandleMap([spec([0, 1]), spec([2])], REST, STRETCH)
    first = handle_map.targets(np.array([NONE, NONE])).copy()
    turn = motion(rotation_z(0.5))
    second = handle_map.targets(np.array([NONE, turn]))
    assert np.array_equal(second[:2], first[:2])
    np.testing.assert_allclose(second[2:], moved(turn, [2]), atol=1e-14)


def test_shared_vertices_take_the_weighted_mean_and_the_largest_strength():
    handle_map = HandleMap([spec([0, 4, 5], [1.0, 0.25, 0.5]), spec([4, 5, 6], [0.75, 0.5, 0.3])], REST, STRETCH)
    turn, shift = motion(rotation_z(1.0)), motion(shift=(0.0, 1.0, 0.0))
    targets = handle_map.targets(np.array([turn, shift]))
    rows = {int(vertex): row for row, vertex in enumerate(handle_map.vertices)}
    assert sorted(rows) == [0, 4, 5, 6]
    assert {vertex: float(handle_map.strengths[row]) for vertex, row in rows.items()} == {
        0: 1.0,
        4: 0.75,
        5: 0.5,
        6: 0.3,
    }
    for vertex, share in ((4, 0.25), (5, 0.5)):
        expected = share * moved(turn, [vertex]) + (1.0 - share) * moved(shift, [vertex])
        np.testing.assert_allclose(targets[rows[vertex]], expected[0], atol=1e-14)


def test_shared_vertices_follow_when_any_of_their_handles_moves():
    handle_map = HandleMap([spec([0, 1]), spec([1, 2])], REST, STRETCH)
    handle_map.targets(np.array([NONE, NONE]))
    shift = motion(shift=(2.0, 0.0, 0.0))
    targets = handle_map.targets(np.array([NONE, shift]))
    expected = 0.5 * (moved(NONE, [1]) + moved(shift, [1]))
    np.testing.assert_allclose(targets[handle_map.vertices.tolist().index(1)], expected[0], atol=1e-14)


def test_weight_zero_is_free_and_more_than_one_counts_as_one():
    handle_map = HandleMap([spec([0, 1, 2], [0.0, 2.0, 0.5])], REST, STRETCH)
    assert handle_map.vertices.tolist() == [1, 2]
    assert handle_map.strengths.tolist() == [1.0, 0.5]


def test_an_empty_group_beside_a_full_one_is_fine():
    handle_map = HandleMap([spec([]), spec([2])], REST, STRETCH)
    np.testing.assert_allclose(
        handle_map.targets(np.array([motion(rotation_z(1.0)), NONE])), moved(NONE, [2]), atol=1e-14
    )


def test_rotations_are_those_of_the_handles_as_seen():
    # A motion that is rigid as seen is a stretched rotation in object space.
    rotation = rotation_z(0.8)
    turn = motion(np.linalg.inv(STRETCH) @ rotation @ STRETCH)
    handle_map = HandleMap([spec([0, 1]), spec([1, 2])], REST, STRETCH)
    rotations = handle_map.rotations(np.array([turn, NONE]))
    by_vertex = dict(zip(handle_map.vertices.tolist(), rotations, strict=True))
    np.testing.assert_allclose(by_vertex[0], rotation, atol=1e-12)
    np.testing.assert_allclose(by_vertex[2], np.eye(3), atol=1e-12)
    np.testing.assert_allclose(by_vertex[1], rotation_z(0.4), atol=1e-12)  # the mean of two turns is half way


def test_nearest_rotations_are_proper_even_of_mirrors():
    matrices = np.array([np.diag([1.0, 1.0, -1.0]), 3.0 * rotation_z(2.0), np.zeros((3, 3))])
    rotations = nearest_rotations(matrices)
    np.testing.assert_allclose(np.linalg.det(rotations), 1.0)
    np.testing.assert_allclose(rotations[1], rotation_z(2.0), atol=1e-12)


@pytest.mark.parametrize(
    ("specs", "message"),
    [
        ([spec([0, 12])], "Handle 'Tail' has a vertex outside 0 to 11: check its vertex group"),
        ([spec([-1])], "Handle 'Tail' has a vertex outside 0 to 11: check its vertex group"),
        (
            [spec([0, 1], [1.0])],
            r"Handle 'Tail' has vertices of shape \(2,\) but weights of shape \(1,\): give one weight per vertex",
        ),
        ([spec([0], [0.0])], "No vertex is pinned or has a handle: add a pin or a handle, or give its group weight"),
        ([], "No vertex is pinned or has a handle: add a pin or a handle, or give its group weight"),
    ],
)
def test_bad_groups_are_refused(specs, message):
    with pytest.raises(ValueError, match=rf"^{message}$"):
        HandleMap(specs, REST, STRETCH)


def test_bad_matrices_are_refused():
    handle_map = HandleMap([spec([0], name="Paw"), spec([1])], REST, STRETCH)
    with pytest.raises(ValueError, match=r"^matrices have shape \(1, 4, 4\), expected \(2, 4, 4\)$"):
        handle_map.targets(np.array([NONE]))
    with pytest.raises(ValueError, match=r"^Handle 'Paw' has a transform that is not finite: reset it$"):
        handle_map.targets(np.array([NONE * np.nan, NONE]))


def test_vertices_are_at_their_base_while_their_handle_has_not_moved():
    base = np.add(REST, (0.0, 0.0, 3.0))
    based = HandleSpec("Pull", np.array([2, 3], dtype=np.int32), np.ones(2), base=base)
    handle_map = HandleMap([spec([3, 1]), based], REST, STRETCH)
    targets = dict(zip(handle_map.vertices.tolist(), handle_map.targets(np.array([NONE, NONE])), strict=True))
    np.testing.assert_allclose(targets[1], STRETCH @ REST[1], atol=1e-14)
    np.testing.assert_allclose(targets[2], STRETCH @ base[2], atol=1e-14)
    np.testing.assert_allclose(targets[3], STRETCH @ (REST[3] + base[3]) / 2.0, atol=1e-14)
    turn = motion(rotation_z(0.7), (1.0, 0.0, 0.0))
    targets = dict(zip(handle_map.vertices.tolist(), handle_map.targets(np.array([NONE, turn])), strict=True))
    np.testing.assert_allclose(targets[2], STRETCH @ (turn[:3, :3] @ base[2] + turn[:3, 3]), atol=1e-14)


def test_a_bone_has_four_places_that_go_with_it():
    ends = np.array([[1.0, 2.0, 3.0], [1.0, 2.0, 5.0]])
    turn, before = motion(rotation_z(0.7), (0.3, 0.0, 1.0)), motion(shift=(0.0, 0.0, 2.0))
    bone = HandleSpec("Bone", np.empty(0, np.int32), np.empty(0), segment=Segment(ends, before))
    handle_map = HandleMap([spec([3]), bone], REST, STRETCH)
    in_solver = ends @ STRETCH.T
    np.testing.assert_allclose(handle_map.segments, in_solver[None], atol=1e-14)
    length = np.linalg.norm(in_solver[1] - in_solver[0])
    corners = in_solver[0] + length * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    whole = turn @ before
    expected = (corners @ np.linalg.inv(STRETCH).T @ whole[:3, :3].T + whole[:3, 3]) @ STRETCH.T
    targets = handle_map.targets(np.array([NONE, turn]))
    np.testing.assert_allclose(targets[1:], expected, atol=1e-13)
    np.testing.assert_allclose(targets[:1], moved(NONE, [3]), atol=1e-14)
    assert handle_map.rotations(np.array([NONE, turn])).shape == (5, 3, 3)
