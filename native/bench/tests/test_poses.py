# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses of the quality benchmark: the same pose at every density."""

import numpy as np
import pytest
from measure.inputs.mesh import make_mesh
from measure.inputs.poses import finer, knee, named_poses, pull, sample_poses, wide_pieces, wing
from measure.inputs.solids import plate
from measure.metrics.shape import facing
from measure.runs.posing import Posing
from measure.runs.quality import chosen, densities, file_name
from surfaces import is_closed, volume


@pytest.fixture(scope="module")
def poses():
    return list(sample_poses())


def test_sample_poses_are_of_closed_meshes_with_parts_apart(poses):
    assert len({file_name(pose) for pose in poses}) == len(poses)
    for pose in poses:
        assert is_closed(pose.mesh.triangles)
        assert volume(pose.mesh.positions, pose.mesh.triangles) > 0
        assert 9_000 < len(pose.mesh.positions) < 13_000
        assert np.linalg.norm(np.ptp(pose.mesh.positions, axis=0)) == pytest.approx(1.0)
        assert len(np.intersect1d(pose.held, pose.moved)) == 0
        assert np.count_nonzero(pose.measured()) > 100


def test_poses_are_chosen_by_name(poses):
    assert [pose.name for pose in chosen(poses, ["twist", "knee"])] == ["knee", "twist"]
    assert chosen(poses, []) == poses


def test_a_name_that_no_pose_has_is_an_error(poses):
    with pytest.raises(ValueError, match='no pose is named "elbow"; the names are "knee", "bend", '):
        chosen(poses, ["knee", "elbow"])


def test_no_share_of_a_pose_moves_nothing(poses):
    for pose in poses:
        task = pose.task(0.0)
        np.testing.assert_allclose(task.targets, pose.mesh.positions[task.vertices], atol=1e-8)


def test_moved_parts_move_rigidly(poses):
    for pose in poses:
        rest = pose.mesh.positions[pose.moved]
        for share in (0.3, 1.0):
            moved = pose.motion(rest, share)
            assert np.linalg.norm(moved - rest, axis=1).max() > 0.01
            spans = [np.linalg.norm(p - p[0], axis=1) for p in (rest, moved)]
            np.testing.assert_allclose(*spans, atol=1e-12)


def test_a_finer_pose_holds_and_moves_the_same_pieces_of_surface():
    coarse = knee()
    fine = finer(coarse)
    for part, finer_part in ((coarse.held, fine.held), (coarse.moved, fine.moved)):
        inside, inside_finer = (
            np.isin(mesh.triangles, vertices).all(axis=1)
            for mesh, vertices in ((coarse.mesh, part), (fine.mesh, finer_part))
        )
        np.testing.assert_array_equal(np.repeat(inside, 4), inside_finer)


def test_densities_end_at_the_most_vertices():
    sizes = [len(pose.mesh.positions) for pose in densities(wing(), 5)]
    assert sizes == [10_302, 41_202, 164_802]
    assert len(list(densities(wing(), 1))) == 1


def test_a_patch_stands_for_its_vertex():
    posings = [Posing(pull("pull", radius), "plain") for radius in (0.0, 0.03)]
    single, patch = (posing.targets(0.0) for posing in posings)
    assert len(single) == len(patch)
    assert np.linalg.norm(patch[-1] - single[-1]) < 0.003
    np.testing.assert_allclose(posings[1].targets(1.0)[-1] - patch[-1], [0, 0, 0.1])


def test_the_walls_of_a_plate_face_each_other():
    mesh = make_mesh("plate", *plate((2.0, 1.0, 0.1), (6, 4)))
    assert is_closed(mesh.triangles)
    front, back = facing(mesh.positions, 2)
    assert len(front) == len(back) == 7 * 5
    np.testing.assert_allclose(
        mesh.positions[front] - mesh.positions[back], np.tile([0, 0, 0.1 / np.sqrt(5.01)], (35, 1)), atol=1e-12
    )


def test_named_meshes_get_a_bend_and_a_pull():
    mesh = knee().mesh
    bend, pulled = named_poses(mesh)
    assert (len(bend.held), len(bend.moved)) == (621, 249)
    assert len(pulled.moved) == 1
    assert pulled.patch_radius > 0
    assert pulled.moved[0] not in pulled.held


def test_wide_pieces_of_a_slice():
    mesh = make_mesh("plate", *plate((1.0, 0.5, 0.1), (40, 4)))
    length = np.ptp(mesh.positions[:, 0])
    x, y = mesh.positions[:, 0] / length, mesh.positions[:, 1]
    end, other_end = (np.flatnonzero(mask) for mask in (x < 0.2, x > 0.76))
    corner = np.flatnonzero((np.abs(x - 0.5) < 0.03) & (y > y.max() - 0.01 * length))
    slice_ = np.random.default_rng(5).permutation(np.concatenate([corner, end, other_end])).astype(np.int32)
    widths = [np.linalg.norm(np.ptp(mesh.positions[piece], axis=0)) for piece in (corner, end, other_end)]
    assert widths[0] < 0.2 < widths[1] < widths[2]

    def kept(width):
        return np.sort(wide_pieces(mesh, slice_, width))

    np.testing.assert_array_equal(kept(0.0), np.sort(slice_))
    np.testing.assert_array_equal(kept(0.2), np.sort(np.concatenate([end, other_end])))
    np.testing.assert_array_equal(kept(9.0), other_end)
