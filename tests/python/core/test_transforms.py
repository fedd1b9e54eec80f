# SPDX-License-Identifier: GPL-3.0-or-later
"""A linear map of many points, rotations, and Blender's Apply."""

import numpy as np
import pytest
from arap_deform.core.transforms import (
    BLOCK,
    applied_map,
    fitted_rotations,
    has_no_inverse,
    inverted,
    map_points,
    nearest_rotations,
    rotation,
    transformed,
)
from sample_meshes import rotation_z

PLACE = np.eye(4)
PLACE[:3] = np.column_stack([rotation_z(0.5) * (1.0, 2.0, 1.0), (3.0, 0.0, 1.0)])
POINTS = np.random.default_rng(3).uniform(size=(10, 3)).astype(np.float32)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("n", [0, 1, BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 5])
def test_every_point_is_mapped(n, dtype):
    rng = np.random.default_rng(11)
    points = rng.normal(size=(n, 3)).astype(dtype)
    linear = rng.normal(size=(3, 3)).astype(dtype)
    mapped = np.full_like(points, np.nan)
    map_points(points, linear, mapped)
    np.testing.assert_allclose(mapped, np.einsum("ij,kj->ik", points, linear), rtol=0, atol=16 * np.finfo(dtype).eps)


def test_the_inverse_of_affine_matrices():
    matrices = np.tile(np.eye(4), (20, 2, 1, 1))
    matrices[..., :3, :] = np.random.default_rng(5).normal(size=(20, 2, 3, 4))
    np.testing.assert_allclose(inverted(matrices), np.linalg.inv(matrices), rtol=1e-9)
    np.testing.assert_allclose(inverted(PLACE) @ PLACE, np.eye(4), atol=1e-15)
    matrices[3, 1, 0] = 0.0
    with pytest.raises(np.linalg.LinAlgError, match="Singular"):
        inverted(matrices)


def test_part_of_an_array_is_written_in_place():
    points = np.arange(6.0).reshape(2, 3)
    table = np.zeros((4, 3))
    map_points(points, 2.0 * np.eye(3), table[1:3])
    np.testing.assert_array_equal(table, [[0, 0, 0], *(2 * points), [0, 0, 0]])


def test_columns_of_an_array_are_refused():
    with pytest.raises(ValueError, match="contiguous"):
        map_points(np.zeros((4, 3)), np.eye(3), np.zeros((4, 5))[:, :3])


def test_a_rotation_turns_by_its_length_about_its_direction():
    np.testing.assert_array_equal(rotation(np.zeros(3)), np.eye(3))
    np.testing.assert_allclose(rotation(np.array([0.0, 0.0, 2.5])), rotation_z(2.5), atol=1e-15)
    turn = np.array([0.3, -1.2, 0.5])
    matrix = rotation(turn)
    np.testing.assert_allclose(matrix @ turn, turn, atol=1e-15)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(3), atol=1e-15)
    assert np.trace(matrix) == pytest.approx(1.0 + 2.0 * np.cos(np.linalg.norm(turn)))
    np.testing.assert_allclose(rotation(0.5 * turn) @ rotation(0.5 * turn), matrix, atol=1e-15)


def test_fitted_rotations_are_those_of_singular_values_for_flat_and_mirrored_points_too():
    random = np.random.default_rng(2)
    rest = random.normal(size=(300, 12, 3))
    rest[:100, :, 2] = 0.0
    rest[100:200] *= (1.0, 0.3, 0.01)
    turns = nearest_rotations(random.normal(size=(300, 3, 3)))
    shown = np.einsum("nij,nkj->nki", turns, rest) + 0.001 * random.normal(size=rest.shape)
    shown[250:] *= (1.0, 1.0, -1.0)
    rest, shown = (points - points.mean(axis=1, keepdims=True) for points in (rest, shown))
    covariances = np.einsum("nki,nkj->nij", shown, rest)
    found = fitted_rotations(covariances)
    np.testing.assert_allclose(found, nearest_rotations(covariances), atol=1e-6)
    np.testing.assert_allclose(found @ found.transpose(0, 2, 1), np.tile(np.eye(3), (300, 1, 1)), atol=1e-12)
    assert (np.linalg.det(found) > 0.0).all()
    np.testing.assert_allclose(found[:100], turns[:100], atol=0.01)


def test_the_rotation_of_nothing_is_none_and_that_of_a_line_the_smallest():
    line = np.outer(np.array([0.6, 0.8, 0.0]), np.array([1.0, 0.0, 0.0]))
    smallest = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(fitted_rotations(np.array([np.zeros((3, 3)), line])), [np.eye(3), smallest], atol=1e-6)


@pytest.mark.parametrize("is_flat", [False, True])
def test_what_the_object_has_lost_its_coordinates_have(is_flat):
    points = POINTS * np.float32([1.0, 1.0, not is_flat])
    now = transformed(PLACE, points.astype(np.float64)).astype(np.float32)
    found = applied_map(PLACE, points, np.eye(4), now)
    np.testing.assert_allclose(found, PLACE)
    assert applied_map(PLACE, points, 1.001 * np.eye(4), now) is None, "moved besides"
    assert applied_map(PLACE, points, np.eye(4), 1.001 * now) is None, "edited besides"


@pytest.mark.parametrize(
    ("diagonal", "is_lost"),
    [((1.0, 1.0, 0.0), True), ((0.0, 0.0, 0.0), True), ((1.0, np.nan, 1.0), True), ((1e-3, 2e-3, 1e-3), False)],
)
def test_what_is_flattened_does_not_come_back(diagonal, is_lost):
    assert has_no_inverse(PLACE @ np.diag([*diagonal, 1.0])) is is_lost


def test_what_moves_alone_is_not_applied():
    a_little = PLACE + 1e-7
    assert applied_map(PLACE, POINTS, a_little, POINTS) is None
    assert applied_map(PLACE, POINTS, np.zeros((4, 4)), 2.0 * POINTS) is None, "scaled to nothing"
    assert applied_map(np.zeros((4, 4)), 0.0 * POINTS, PLACE, POINTS) is None, "never seen"
    assert applied_map(PLACE, POINTS, PLACE, np.nan * POINTS) is None
