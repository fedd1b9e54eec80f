# SPDX-License-Identifier: GPL-3.0-or-later
"""CageDeformation from the outside: arrays in and out, options, jobs, errors. What it computes: tests/native."""

from itertools import product
from typing import NamedTuple

import arap_native
import numpy as np
import pytest
from arap_native import CageDeformation, CageOptions
from numpy.typing import NDArray
from sample_meshes import rotation_z, tube

GREEN = CageOptions(coordinates="green")


class Cage(NamedTuple):
    positions: NDArray[np.float64]
    corner_vertices: NDArray[np.int32]
    face_sizes: NDArray[np.int32]


def cube() -> Cage:
    """From -1 to 1, of six quads."""
    corners = np.array(list(product((-1.0, 1.0), repeat=3)))
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return Cage(corners, np.array(quads, np.int32).ravel(), np.full(6, 4, np.int32))


def points_inside(n: int = 20) -> NDArray[np.float64]:
    return np.random.default_rng(1).uniform(-0.9, 0.9, (n, 3))


@pytest.mark.parametrize("coordinates", ["mean_value", "green", "harmonic"])
def test_points_turn_with_the_cage(coordinates):
    points = points_inside()
    cage = CageDeformation(points, *cube(), options=CageOptions(coordinates=coordinates))
    assert cage.deform(cube().positions) == pytest.approx(points, abs=1e-14)
    turned = 2 * cube().positions @ rotation_z(1.0).T + 3
    assert cage.deform(turned) == pytest.approx(2 * points @ rotation_z(1.0).T + 3, abs=1e-13)


def test_weights_say_where_a_point_goes():
    points = points_inside()
    moved = cube().positions + np.random.default_rng(2).uniform(-0.3, 0.3, (8, 3))
    cage = CageDeformation(points, *cube())
    vertices, triangles = cage.weights(3)
    assert triangles.shape == (0,)
    assert vertices.sum() == pytest.approx(1)
    assert vertices @ moved == pytest.approx(cage.deform(moved)[3], abs=1e-7)
    vertices, triangles = CageDeformation(points, *cube(), options=GREEN).weights(3)
    assert (vertices.shape, triangles.shape) == ((8,), (24,))


def test_a_cage_may_be_of_triangles():
    quads = cube().corner_vertices.reshape(-1, 4)
    triangles = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    cage = CageDeformation(points_inside(), cube().positions, triangles)
    assert (cage.n_points, cage.n_vertices, cage.n_triangles) == (20, 8, 12)
    assert repr(cage) == "<CageDeformation: 20 points, 8 vertices of the cage, 1 thread>"


def test_out_takes_the_result():
    cage = CageDeformation(points_inside(), *cube())
    out = np.empty((20, 3), np.float32)
    assert cage.deform(2 * cube().positions, out=out) is out
    assert out == pytest.approx(2 * points_inside(), abs=1e-6)
    with pytest.raises(ValueError, match=r"^out has shape \(2, 3\), expected \(20, 3\): one row per point"):
        cage.deform(cube().positions, out=np.empty((2, 3), np.float32))


def test_a_made_cage_carries_its_mesh():
    mesh = tube()
    positions, faces = arap_native.make_cage(*mesh, cells=6)
    assert (positions.dtype, faces.dtype, faces.shape[1]) == (np.float64, np.int32, 4)
    cage = CageDeformation(mesh.positions, positions, faces, options=GREEN)
    assert cage.deform(positions + 1.0) == pytest.approx(mesh.positions + 1.0, abs=1e-12)
    with pytest.raises(ValueError, match=r"^cells = 1, must be >= 2 and <= 50"):
        arap_native.make_cage(*mesh, cells=1)


@pytest.mark.parametrize("coordinates", ["mean_value", "harmonic"])
def test_a_deformation_goes_from_one_shape_to_another(coordinates):
    options = CageOptions(coordinates=coordinates)
    source = CageDeformation(points_inside(200), *cube(), options=options)
    moved = cube().positions + np.random.default_rng(2).uniform(-0.3, 0.3, (8, 3))
    fitted = source.fit(source.deform(moved), smoothness=1e-9)
    assert fitted == pytest.approx(moved, abs=1e-4)
    target = cube()._replace(positions=cube().positions * [2.0, 2.0, 4.0] + 5.0)
    transferred = arap_native.transfer_cage(cube(), fitted, target)
    assert transferred.shape == (8, 3)
    grown = arap_native.transfer_cage(cube(), 2 * cube().positions @ rotation_z(1.0).T, target)
    assert grown == pytest.approx(2 * (target.positions - 5.0) @ rotation_z(1.0).T + 5.0, abs=1e-12)
    triangles = np.ascontiguousarray(cube().corner_vertices.reshape(-1, 4)[:, :3])
    same = (cube().positions, triangles)
    assert arap_native.transfer_cage(same, moved, same) == pytest.approx(moved, abs=1e-12)


def test_a_job_does_what_the_constructor_does():
    moved = cube().positions * [1.0, 1.0, 1.5] + cube().positions[:, ::-1] ** 2
    job = CageDeformation.begin_bind(points_inside(), *cube(), options=GREEN)
    cage = job.result()
    assert type(cage) is CageDeformation
    assert np.array_equal(cage.deform(moved), CageDeformation(points_inside(), *cube(), options=GREEN).deform(moved))


def test_a_cage_is_made_by_a_job_too():
    job = arap_native.begin_make_cage(*cube(), cells=3)
    for made, expected in zip(job.result(), arap_native.make_cage(*cube(), cells=3), strict=True):
        assert np.array_equal(made, expected)
    with pytest.raises(arap_native.Cancelled, match="making the cage was cancelled"):
        arap_native.make_cage(*cube(), progress=lambda _: False)


def test_progress_may_stop_it():
    told = []
    CageDeformation(points_inside(), *cube(), progress=told.append)
    assert told[-1] == 1
    with pytest.raises(arap_native.Cancelled, match="weights of the cage was cancelled"):
        CageDeformation(points_inside(), *cube(), progress=lambda _: False)


def test_options_are_named_values():
    assert repr(CageOptions()) == "CageOptions(coordinates='mean_value', grid_spacing=0.015625, threads=0)"
    assert CageDeformation(points_inside(), *cube(), options=CageOptions(threads=2)).threads == 2
    with pytest.raises(ValueError, match=r"^coordinates = 'gren', must be one of 'mean_value', 'green', 'harmonic'"):
        CageOptions(coordinates="gren")
    with pytest.raises(ValueError, match=r"^threads = -1, must be "):
        CageOptions(threads=-1)


def test_what_is_wrong_is_told_in_words():
    positions, corners, sizes = cube()
    with pytest.raises(ValueError, match=r"^points has shape \(3,\), expected \(n, 3\): one row per point"):
        CageDeformation(np.zeros(3), positions, corners, sizes)
    with pytest.raises(ValueError, match=r"^the cage is not closed: its edge from vertex \d to \d has 1 face;"):
        CageDeformation(points_inside(), positions, corners[4:], sizes[1:])
    with pytest.raises(ValueError, match=r"^cage: rest_positions has shape \(8, 2\), expected \(n, 3\): one row per"):
        CageDeformation(points_inside(), positions[:, :2], corners, sizes)
    with pytest.raises(ValueError, match=r"^1 of 2 points are not inside of the cage \(1\), "):
        CageDeformation(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0]]), *cube(), options=GREEN)
    cage = CageDeformation(points_inside(), *cube())
    with pytest.raises(ValueError, match=r"^cage_positions has shape \(20, 3\), expected \(8, 3\): one row per vertex"):
        cage.deform(points_inside())
    with pytest.raises(ValueError, match=r"^point 20 is not there, there are points 0 to 19"):
        cage.weights(20)
    with pytest.raises(ValueError, match=r"^positions has shape \(8, 3\), expected \(20, 3\): one row per point"):
        cage.fit(positions)
    with pytest.raises(ValueError, match=r"^moved_source has shape \(20, 3\), expected \(8, 3\): one row per vertex"):
        arap_native.transfer_cage(cube(), points_inside(), cube())
    with pytest.raises(TypeError, match=r"^target is not a tuple of arrays, expected \(rest_positions, faces\)$"):
        arap_native.transfer_cage(cube(), positions, positions)
    with pytest.raises(ValueError, match=r"^target: faces has shape \(24,\), expected \(m, k\): one row per face;"):
        arap_native.transfer_cage(list(cube()), positions, (positions, corners))
    with pytest.raises(ValueError, match=r"^source: rest_positions: vertex 0 is at \(nan, "):
        arap_native.transfer_cage((positions * np.nan, corners, sizes), positions, cube())
