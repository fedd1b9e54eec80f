# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and tasks of the benchmarks."""

import numpy as np
import pytest
from measure.inputs.mesh import (
    creature,
    load_off,
    make_mesh,
    mesh_files,
    midpoint_subdivision,
    triangulated,
)
from measure.inputs.tasks import bend, displacement, read_task, rotation, write_task
from surfaces import areas, is_closed

TETRAHEDRON = """OFF  # four corners
4 4 6

0 0 0
2 0 0
0 2 0
0 0 1
3 0 2 1
3 0 1 3
3 1 2 3
3 2 0 3
"""


@pytest.fixture
def tetrahedron(tmp_path):
    path = tmp_path / "tetrahedron.off"
    path.write_text(TETRAHEDRON)
    return load_off(path)


def test_off_files_are_read_and_scaled_to_a_diagonal_of_one(tetrahedron):
    assert tetrahedron.name == "tetrahedron"
    np.testing.assert_allclose(tetrahedron.positions[1], [2 / 3, 0, 0])
    np.testing.assert_array_equal(tetrahedron.triangles[3], [2, 0, 3])
    assert tetrahedron.corner_vertices.dtype == tetrahedron.face_sizes.dtype == np.int32


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("PLY\n1 1 0\n", "not an OFF file"),
        (TETRAHEDRON.replace("4 4 6", "4 5 6"), "8 lines for 4 vertices and 5 faces"),
        (TETRAHEDRON.replace("3 2 0 3", "4 2 0 3 1"), "different numbers of corners"),
    ],
)
def test_off_files_that_are_refused(tmp_path, text, message):
    path = tmp_path / "bad.off"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        load_off(path)


def test_a_mesh_at_one_place_is_refused():
    with pytest.raises(ValueError, match="all vertices are at one place"):
        make_mesh("dot", np.ones((3, 3)), np.array([[0, 1, 2]]))


def test_midpoint_subdivision_keeps_the_surface(tetrahedron):
    finer = midpoint_subdivision(tetrahedron)
    assert len(finer.positions) == 4 + 6
    assert len(finer.triangles) == 4 * 4
    np.testing.assert_array_equal(finer.positions[:4], tetrahedron.positions)
    total, expected = (areas(mesh.positions, mesh.triangles).sum() for mesh in (finer, tetrahedron))
    assert total == pytest.approx(expected)
    assert np.ptp(finer.positions, axis=0) == pytest.approx(np.ptp(tetrahedron.positions, axis=0))


def test_midpoint_subdivision_stays_closed_and_oriented(tetrahedron):
    finer = midpoint_subdivision(midpoint_subdivision(tetrahedron))
    assert is_closed(finer.triangles)
    assert len(finer.positions) - len(finer.triangles) // 2 == 2  # Euler's, of a sphere


def test_quads_become_two_triangles_each():
    square = make_mesh("square", np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]), np.array([[0, 1, 2, 3]]))
    cut = triangulated(square)
    np.testing.assert_array_equal(cut.triangles, [[0, 1, 2], [0, 2, 3]])
    assert triangulated(cut) is cut


def test_pentagons_are_not_triangulated():
    corners = np.column_stack([np.cos(np.arange(5)), np.sin(np.arange(5)), np.zeros(5)])
    with pytest.raises(ValueError, match="only triangles and quads"):
        triangulated(make_mesh("pentagon", corners, np.arange(5)[None]))


def test_mesh_files_are_files_and_folders(tmp_path):
    names = ["b.off", "a.off", "note.txt"]
    for name in names:
        (tmp_path / name).write_text("")
    single = tmp_path / "note.txt"
    assert mesh_files(f"{tmp_path}:{single}") == [tmp_path / "a.off", tmp_path / "b.off", single]
    assert mesh_files("") == []
    with pytest.raises(ValueError, match="nowhere is no file and no folder"):
        mesh_files("nowhere")


def test_the_bend_turns_the_top_by_ninety_degrees():
    mesh = creature(10_000)
    task = bend(mesh)
    n_held = int(np.ceil(0.05 * len(mesh.positions)))
    assert len(np.unique(task.vertices)) == len(task.vertices) == n_held + int(np.ceil(0.02 * len(mesh.positions)))
    rest = mesh.positions[task.vertices]
    np.testing.assert_array_equal(task.targets[:n_held], rest[:n_held])
    before, after = (p[n_held:] - p[n_held:].mean(axis=0) for p in (rest, task.targets))
    turn = np.linalg.lstsq(before, after, rcond=None)[0].T
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-9)
    assert np.trace(turn) == pytest.approx(1.0)  # 1 + 2 cos


def test_no_share_of_a_displacement_moves_nothing():
    mesh = creature(10_000)
    task = displacement(mesh, 0.0)
    np.testing.assert_allclose(task.targets, mesh.positions[task.vertices], atol=1e-15)


def test_rotations_turn_counter_clockwise():
    np.testing.assert_allclose(rotation(np.array([0.0, 0, 2]), np.pi / 2) @ [1, 0, 0], [0, 1, 0], atol=1e-15)


def test_task_files_come_back_as_they_were(tmp_path, tetrahedron):
    task = displacement(tetrahedron, 1.0)
    write_task(tmp_path / "tetrahedron", tetrahedron, task)
    mesh_back, task_back = read_task(tmp_path / "tetrahedron")
    assert mesh_back.name == tetrahedron.name
    for written, read in zip((*tetrahedron[1:], *task), (*mesh_back[1:], *task_back), strict=True):
        np.testing.assert_array_equal(written, read)
        assert written.dtype == read.dtype
