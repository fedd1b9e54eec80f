# SPDX-License-Identifier: GPL-3.0-or-later
"""Special kinds of meshes of the quality benchmark: what is special about them, and that nothing else is."""

import numpy as np
import pytest
from measure.inputs.kinds import Kind, kinds
from measure.inputs.mesh import make_mesh
from measure.inputs.poses import Pose, View
from measure.inputs.solids import cubes, finer_where, joined, sheet, welded, with_needles
from measure.runs.quality import file_name, measure_kind
from surfaces import areas, faces_at_sides, volume

BOX = np.ones((3, 2, 2), dtype=bool)


@pytest.fixture(scope="module")
def by_name():
    return {kind.pose.name: kind for kind in kinds()}


def box_mesh():
    return make_mesh("box", *cubes(BOX))


def test_cubes_have_a_closed_surface_that_looks_out():
    positions, triangles = cubes(BOX, side=0.5)
    assert list(faces_at_sides(triangles)) == [0, 0, 3 * len(triangles) // 2]
    assert volume(positions, triangles) == pytest.approx(12 * 0.125)
    assert areas(positions, triangles).sum() == pytest.approx(2 * (6 + 6 + 4) * 0.25)


def test_a_hole_has_walls():
    is_solid = np.ones((3, 3, 3), dtype=bool)
    is_solid[1, 1, :] = False
    positions, triangles = cubes(is_solid)
    assert volume(positions, triangles) == pytest.approx(24)
    assert areas(positions, triangles).sum() == pytest.approx(2 * 8 + 4 * 9 + 4 * 3)


def test_a_sheet_is_one_layer_with_a_border():
    positions, triangles = sheet((2.0, 1.0), (4, 2))
    assert list(faces_at_sides(triangles)) == [0, 12, 18]
    assert areas(positions, triangles).sum() == pytest.approx(2.0)
    np.testing.assert_allclose([positions.min(axis=0), positions.max(axis=0)], [[0, -0.5, 0], [2, 0.5, 0]])


def test_sheets_side_by_side_are_welded_at_their_border():
    positions, triangles = sheet((1.0, 1.0), (2, 2))
    apart = joined((positions, triangles), (positions + np.array([1.0, 0.0, 0.0]), triangles))
    together = welded(apart)
    assert (len(apart[0]), len(together[0])) == (18, 15)
    assert list(faces_at_sides(together[1])) == [0, 12, 18]
    assert areas(*together).sum() == pytest.approx(2.0)


def test_needles_cut_triangles_and_nothing_else():
    mesh = box_mesh()
    cut = with_needles(mesh, np.array([0, 7, 8], dtype=np.int32), 1e-3)
    assert list(faces_at_sides(cut.triangles)) == [0, 0, 3 * len(cut.triangles) // 2]
    assert len(cut.triangles) == len(mesh.triangles) + 6
    before, after = areas(mesh.positions, mesh.triangles), areas(cut.positions, cut.triangles)
    assert after.sum() == pytest.approx(before.sum())
    np.testing.assert_allclose(np.sort(after)[:3], 1e-3 * before[[0, 7, 8]], rtol=1e-9)
    assert volume(cut.positions, cut.triangles) == pytest.approx(volume(mesh.positions, mesh.triangles))


@pytest.mark.parametrize("chosen", [[], [3], [3, 4, 20], list(range(len(box_mesh().triangles)))])
def test_finer_somewhere_leaves_no_vertex_on_a_side(chosen):
    mesh = box_mesh()
    is_chosen = np.isin(np.arange(len(mesh.triangles)), chosen)
    finer = finer_where(mesh, is_chosen)
    assert list(faces_at_sides(finer.triangles)) == [0, 0, 3 * len(finer.triangles) // 2]
    np.testing.assert_array_equal(finer.positions[: len(mesh.positions)], mesh.positions)
    np.testing.assert_array_equal(np.unique(finer.triangles), np.arange(len(finer.positions)))
    assert areas(finer.positions, finer.triangles).sum() == pytest.approx(areas(mesh.positions, mesh.triangles).sum())
    assert volume(finer.positions, finer.triangles) == pytest.approx(volume(mesh.positions, mesh.triangles))
    quarter = areas(finer.positions, finer.triangles).min() / areas(mesh.positions, mesh.triangles).min()
    assert quarter == pytest.approx(0.25 if chosen else 1.0)


def test_kinds_are_poses_whose_parts_are_apart(by_name):
    assert len({file_name(kind.pose) for kind in by_name.values()}) == len(by_name) == 8
    for kind in by_name.values():
        assert len(np.intersect1d(kind.pose.held, kind.pose.moved)) == 0
        task = kind.pose.task(0.0)
        np.testing.assert_allclose(task.targets, kind.pose.mesh.positions[task.vertices], atol=1e-12)


def test_what_is_special_about_each_kind(by_name):
    sides = {name: faces_at_sides(kind.pose.mesh.triangles) for name, kind in by_name.items()}
    assert sides["open sheet"][1] > 0
    assert sides["edges of three faces"][3] == 100
    for name in ("fingers with a gap", "several parts", "slivers", "uneven density"):
        assert list(np.flatnonzero(sides[name])) == [2]
    loose = by_name["loose vertices"].pose.mesh
    assert len(np.unique(loose.triangles)) == len(loose.positions) - 500
    uneven = by_name["uneven density"].pose.mesh
    at = areas(uneven.positions, uneven.triangles)
    assert np.median(at) / at.min() > 10


def test_special_meshes_begin_with_the_sound_one(by_name):
    of_sound = [kind for kind in by_name.values() if kind.sound is not None]
    assert len(of_sound) == 3
    for kind in of_sound:
        rest = kind.sound.mesh.positions
        np.testing.assert_array_equal(kind.pose.mesh.positions[: len(rest)], rest)


@pytest.mark.parametrize("name", ["fingers with a gap", "several parts"])
def test_what_is_known_is_not_what_is_asked_for(by_name, name):
    kind = by_name[name]
    vertices, places = kind.known
    assert len(np.setdiff1d(vertices, np.concatenate([kind.pose.held, kind.pose.moved]))) > 0.8 * len(vertices)
    np.testing.assert_allclose(
        places[np.isin(vertices, kind.pose.held)], kind.pose.mesh.positions[vertices[np.isin(vertices, kind.pose.held)]]
    )


@pytest.mark.parametrize("further", [0.0, 0.1])
def test_off_is_the_distance_from_what_is_known(further):
    mesh = box_mesh()
    vertices = np.arange(len(mesh.positions), dtype=np.int32)
    up = np.array([0.0, 0.0, 0.1])
    view = View((1, 0, 0), (0, 0, 0), 1)
    pose = Pose("shift", mesh, vertices[:0], vertices, lambda points, share: points + share * up, view)
    known = vertices[:4], mesh.positions[:4] + up + [0.0, further, 0.0]
    row, positions = measure_kind(Kind(pose, known=known), "plain", 1.0)
    np.testing.assert_allclose(positions, mesh.positions + up, atol=1e-6)
    assert row["off"] == pytest.approx(further, abs=1e-6)
