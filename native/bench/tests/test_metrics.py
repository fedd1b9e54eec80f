# SPDX-License-Identifier: GPL-3.0-or-later
"""Metrics of the comparison: facts on meshes whose values are known."""

import numpy as np
import pytest
from measure.inputs.mesh import make_mesh
from measure.inputs.solids import cubes, rod, sheet
from measure.metrics.distortion import area_distortion, edge_strain
from measure.metrics.intersections import new_intersections
from measure.metrics.shape import interior_edges
from measure.metrics.thinness import thinness
from measure.metrics.together import asymmetry, parted


def everywhere(mesh):
    return np.ones(len(mesh.positions), dtype=bool)


@pytest.fixture
def cylinder():
    return make_mesh("rod", *rod(4.0, 24, 16))


def test_strain_of_a_mesh_that_is_twice_as_large_is_one(cylinder):
    edges, _ = interior_edges(cylinder.triangles)
    assert edge_strain(edges, cylinder.positions, 2 * cylinder.positions, everywhere(cylinder)) == pytest.approx(1)


def test_area_of_a_sheet_that_is_stretched_along_an_axis():
    mesh = make_mesh("sheet", *sheet((1.0, 1.0), (4, 4)))
    stretched = mesh.positions * [3.0, 1.0, 1.0]
    found = area_distortion(mesh.triangles, mesh.positions, stretched, everywhere(mesh))
    assert found == pytest.approx(np.log(3))
    half = mesh.positions.copy()
    half[:, 0] = np.where(half[:, 0] > 0.3, half[:, 0], 0.3)  # two of the four rows become lines
    assert area_distortion(mesh.triangles, mesh.positions, half, everywhere(mesh)) > np.log(3)


def test_a_thinner_cylinder_is_as_thin_everywhere(cylinder):
    found = thinness(cylinder.triangles, cylinder.positions, cylinder.positions * [0.4, 0.4, 1.0], everywhere(cylinder))
    assert found.median == pytest.approx(0.4)
    assert found.thin == pytest.approx(0.4)


def test_a_waist_shows_in_the_thinnest_and_not_in_the_median():
    mesh = make_mesh("rod", *rod(4.0, 24, 40))
    at_waist = np.abs(mesh.positions[:, 2]) < 0.08 * np.ptp(mesh.positions[:, 2])
    now = np.where(at_waist[:, None], mesh.positions * [0.2, 0.2, 1.0], mesh.positions)
    found = thinness(mesh.triangles, mesh.positions, now, everywhere(mesh))
    assert found.thin == pytest.approx(0.2, abs=0.01)
    assert found.median == pytest.approx(1)


def test_a_sheet_has_no_thickness():
    mesh = make_mesh("sheet", *sheet((1.0, 1.0), (4, 4)))
    assert thinness(mesh.triangles, mesh.positions, mesh.positions, everywhere(mesh)) is None


def test_a_spike_through_the_other_wall_intersects_it():
    mesh = make_mesh("cube", *cubes(np.ones((4, 4, 4), dtype=bool)))
    x, y, z = (mesh.positions / mesh.positions.max()).T
    now = mesh.positions.copy()
    tip = np.flatnonzero((z == 1) & (x == 0.5) & (y == 0.5))
    now[tip, 2] = -0.1
    free = everywhere(mesh)
    cut = new_intersections(mesh.triangles, mesh.positions, now, free)
    assert cut > 4
    assert new_intersections(mesh.triangles, now, mesh.positions, free) == -cut
    free[:] = False
    free[tip] = True
    assert 0 < new_intersections(mesh.triangles, mesh.positions, now, free) < cut, "the wall is held"


def test_a_shape_is_as_far_from_its_mirror_image_as_one_side_of_it_was_moved(cylinder):
    rest = cylinder.positions + 5.0
    assert asymmetry(rest, 1.3 * rest, 0) == pytest.approx(0.3 * 2 * rest[:, 0].mean(), rel=0.01)
    assert asymmetry(rest, rest, 0) < 1e-12
    now = rest.copy()
    now[np.argmax(rest[:, 0])] += [0.0, 0.0, 0.02]
    assert asymmetry(rest, now, 0) == pytest.approx(0.02)


def test_vertices_that_part_are_as_far_as_their_distance_changed():
    rest = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0]])
    now = np.array([[0.0, 0, 0], [0.5, 0, 0], [0, 5, 0]])
    assert parted(np.array([[0, 1], [0, 2]]), rest, now) == pytest.approx(3)
