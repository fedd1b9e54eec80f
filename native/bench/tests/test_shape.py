# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures of deformed surfaces: facts on small meshes."""

import numpy as np
import pytest
from measure.inputs.mesh import make_mesh, midpoint_subdivision
from measure.inputs.tasks import rotation
from measure.metrics.shape import Surface, interior_edges, rotations, thickness

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
OCTAHEDRON = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]])
SIDES = np.array([[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]])


def everywhere(mesh):
    return np.ones(len(mesh.positions), dtype=bool)


def hinge():
    """Two triangles with the edge from 0 to 2 in common; vertex 1 is on the side of x > y."""
    return make_mesh("hinge", SQUARE, np.array([[0, 1, 2], [0, 2, 3]]))


def folded(mesh, angle):
    """Vertex 1 turned about the diagonal edge."""
    positions = mesh.positions.copy()
    positions[1] = rotation(np.array([1.0, 1.0, 0.0]), angle) @ positions[1]
    return positions


def disk(n_rings=6, n_sides=6):
    """A flat disk of rings; vertex 0 is in the middle, the first ring follows, and its fan comes first."""
    angles = 2 * np.pi * np.arange(n_sides) / n_sides
    ring = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(n_sides)])
    positions = np.concatenate([np.zeros((1, 3)), *(k * ring for k in range(1, n_rings + 1))])
    first = 1 + np.arange(n_sides)
    triangles = [np.column_stack([np.zeros(n_sides), first, np.roll(first, -1)])]
    for inner in (first + k * n_sides for k in range(n_rings - 1)):
        outer, next_inner = inner + n_sides, np.roll(inner, -1)
        triangles += [np.column_stack([inner, outer, next_inner + n_sides])]
        triangles += [np.column_stack([inner, next_inner + n_sides, next_inner])]
    return make_mesh("disk", positions, np.concatenate(triangles).astype(np.int32))


@pytest.mark.parametrize("angle", [0.3, -0.3, 1.2, -2.5])
def test_a_folded_edge_has_that_change_of_dihedral_angle(angle):
    mesh = hinge()
    assert abs(Surface(mesh).bends(folded(mesh, angle))[0]) == pytest.approx(abs(angle))


def test_a_fold_to_both_sides_differs_in_sign():
    mesh = hinge()
    up, down = (Surface(mesh).bends(folded(mesh, angle))[0] for angle in (0.5, -0.5))
    assert up == pytest.approx(-down)


def test_a_fold_through_the_half_turn_is_the_shorter_way():
    mesh = hinge()
    start = mesh._replace(positions=folded(mesh, 3.0))
    assert abs(Surface(start).bends(folded(mesh, -3.0))[0]) == pytest.approx(2 * np.pi - 6.0)


def test_convex_edges_are_positive():
    mesh = make_mesh("octahedron", OCTAHEDRON, SIDES)
    flat = mesh._replace(positions=mesh.positions * [1.0, 1.0, 0.0])
    assert len(Surface(mesh).edges) == 12
    # From a shape whose upper and lower edges are flat: all of these become convex.
    bends = Surface(flat).bends(mesh.positions)
    upright = np.isin(Surface(mesh).edges, [2, 5]).any(axis=1)
    np.testing.assert_allclose(bends[upright], np.arccos(1 / 3))


def test_a_rigid_motion_changes_nothing():
    mesh = midpoint_subdivision(make_mesh("octahedron", OCTAHEDRON, SIDES))
    moved = mesh.positions @ rotation(np.array([1.0, 2.0, 3.0]), 2.0).T + [3.0, -1.0, 2.0]
    change = Surface(mesh).change(moved, everywhere(mesh))
    assert max(change.curvature, change.max_deg) < 1e-5
    assert (change.sharp_edges, change.flips) == (0, 0)


def test_scaling_changes_the_integral_of_the_curvature_alone():
    mesh = make_mesh("octahedron", OCTAHEDRON, SIDES)
    change = Surface(mesh).change(3.0 * mesh.positions, everywhere(mesh))
    length = np.linalg.norm(mesh.positions[0] - mesh.positions[1])
    # 12 edges, the integral of H over each is half of angle times length; twice of it comes with a scale of 3.
    assert change.curvature == pytest.approx(2 * 12 * 0.5 * length * np.arccos(1 / 3))
    assert change.max_deg < 1e-5


def test_a_fold_counts_as_sharp_beyond_sixty_degrees():
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    away = np.add(SQUARE, [5.0, 0, 0])
    mesh = make_mesh("two hinges", np.concatenate([SQUARE, away]), np.concatenate([faces, faces + 4]))
    positions = mesh.positions.copy()
    positions[:4] = folded(mesh._replace(positions=mesh.positions[:4]), 0.5 * np.pi)
    surface = Surface(mesh)
    change = surface.change(positions, everywhere(mesh))
    assert change.max_deg == pytest.approx(90)
    assert change.sharp_edges == 1
    elsewhere = np.arange(8) >= 4
    assert surface.change(positions, elsewhere).max_deg == 0.0


def test_a_flipped_face_counts_once():
    mesh = disk()
    surface = Surface(mesh)
    positions = mesh.positions.copy()
    a, b = positions[1], positions[2]
    assert surface.change(positions, everywhere(mesh)).flips == 0
    positions[0] = 0.5 * (a + b) * 1.05  # the middle goes over one edge of its fan, and over no other
    flipped = surface.flipped(positions, np.ones(len(mesh.triangles), dtype=bool))
    np.testing.assert_array_equal(np.flatnonzero(flipped), [0])


def test_a_surface_turned_upside_down_has_no_flips():
    mesh = disk()
    turned = mesh.positions @ rotation(np.array([1.0, 0, 0]), np.pi).T
    assert Surface(mesh).change(turned, everywhere(mesh)).flips == 0


def test_borders_and_edges_of_three_faces_are_not_measured():
    triangles = np.array([[0, 1, 2], [1, 0, 3], [0, 1, 4], [0, 2, 5]], dtype=np.int32)
    edges, faces = interior_edges(triangles)
    assert sorted(edges[0].tolist()) == [0, 2]
    np.testing.assert_array_equal(faces, [[0, 3]])


def test_the_nearest_rotation_of_a_reflection_is_a_rotation():
    np.testing.assert_allclose(rotations(np.diag([3.0, 2.0, -1.0])[None])[0], np.eye(3), atol=1e-12)


def test_thickness_is_a_share_of_that_at_rest_and_negative_where_the_walls_passed():
    mesh = make_mesh("octahedron", OCTAHEDRON, SIDES)
    top, bottom = np.array([2]), np.array([5])
    for share in (0.5, 2.0):
        assert thickness(mesh, top, bottom, mesh.positions * [1, 1, share]) == pytest.approx(share)
    passed = mesh.positions.copy()
    passed[5, 2] = 2 * passed[2, 2]
    assert thickness(mesh, top, bottom, passed) < 0
