# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices a pull takes along and holds, and their mirror images."""

import numpy as np
import pytest
import sample_meshes
from arap_deform.core.graph import face_edges
from arap_deform.core.session_data import SessionMesh
from arap_deform.core.transforms import rotation
from arap_deform.pull import region
from arap_deform.pull.coarse import RestMesh
from arap_deform.pull.region import (
    ITSELF,
    PulledPatch,
    connected_within,
    hold_of_rest,
    mirror_images,
    mirror_signs,
    symmetric_grabs,
    with_root,
)
from sample_meshes import motion, rotation_z

N = 21
GRID = sample_meshes.sheet(N)
POINTS = GRID.positions
EDGES = np.stack(face_edges(GRID.corner_vertices, GRID.face_sizes), axis=1)
FINE = RestMesh(POINTS, EDGES, GRID.corner_vertices, GRID.face_sizes)
MIDDLE = N * N // 2


def at(x, y):
    return np.array([np.linalg.norm(POINTS - (x, y, 0.0), axis=1).argmin()], dtype=np.int32)


def disc(x, y, radius):
    return connected_within(POINTS, EDGES, at(x, y), np.array([x, y, 0.0]), radius)


def test_a_patch_is_the_ball_where_all_is_joined():
    expected = np.flatnonzero(np.linalg.norm(POINTS, axis=1) <= 0.35)
    np.testing.assert_array_equal(disc(0.0, 0.0, 0.35), expected)


def test_a_patch_does_not_jump_over_a_gap():
    """Two sheets, one above the other: near each other, and not joined."""
    points = np.concatenate([POINTS, np.add(POINTS, (0.0, 0.0, 0.05))])
    edges = np.concatenate([EDGES, EDGES + len(POINTS)])
    found = connected_within(points, edges, np.array([MIDDLE]), points[MIDDLE], 0.3)
    np.testing.assert_array_equal(found, disc(0.0, 0.0, 0.3))


def test_a_patch_smaller_than_a_face_is_the_nearest_corner():
    corners = np.array([MIDDLE, MIDDLE + 1, MIDDLE + N, MIDDLE + N + 1], dtype=np.int32)
    found = connected_within(POINTS, EDGES, corners, np.array([0.06, 0.06, 0.0]), 0.01)
    assert found.tolist() == [MIDDLE + N + 1]


def test_the_mesh_of_the_last_drag_is_kept_while_nothing_of_it_changes():
    moved, flipped = POINTS + 1.0, GRID.corner_vertices[::-1].copy()
    last = None
    for points, corners, stretch in (
        (POINTS, GRID.corner_vertices, np.eye(3)),
        (moved, GRID.corner_vertices, np.eye(3)),
        (moved, flipped, np.eye(3)),
        (moved, flipped, 2.0 * np.eye(3)),
    ):
        fine, again = (
            region.fine_of(SessionMesh(points.copy(), corners.copy(), GRID.face_sizes), stretch, EDGES.copy())
            for _ in range(2)
        )
        assert fine is again
        assert fine is not last
        np.testing.assert_array_equal(fine.points, points @ stretch.T)
        last = fine
    region.forget_fine()
    assert region.fine_of(SessionMesh(moved, flipped, GRID.face_sizes), 2.0 * np.eye(3), EDGES) is not last


def test_the_rest_is_free_near_the_grab_held_beyond_and_softly_in_between():
    grab = PulledPatch(disc(0.0, 0.0, 0.21), reach=0.5)  # 0.2 would be on the edge of rounding
    hold = hold_of_rest(FINE, [grab], use_loose_parts=True)
    weights = np.zeros(len(POINTS))
    weights[hold.vertices] = hold.weights
    distance = np.linalg.norm(POINTS, axis=1)
    assert (weights[distance < 0.4 * 0.5 + 0.2] == 0.0).all()
    assert (weights[distance > 0.71] == 1.0).all()
    ring = weights[(distance > 0.45) & (distance < 0.65)]
    assert ((ring > 0.0) & (ring < 1.0)).all()
    order = np.argsort(distance)[: np.count_nonzero(distance < 0.65)]
    assert (np.diff(weights[order]) >= -1e-12).all(), "the farther the firmer"
    assert hold.use_exact


def test_two_grabs_free_what_either_frees():
    grabs = [PulledPatch(disc(-0.5, 0.0, 0.1), 0.3), PulledPatch(disc(0.5, 0.0, 0.1), 0.3)]
    held = [set(hold_of_rest(FINE, [grab], use_loose_parts=True).vertices.tolist()) for grab in grabs]
    assert set(hold_of_rest(FINE, grabs, use_loose_parts=True).vertices.tolist()) == held[0] & held[1]


def test_loose_pieces_that_follow_the_pulled_one_are_not_held():
    """A ball on the sheet, and one far above it."""
    mesh = sample_meshes.joined(
        GRID, sample_meshes.ball((0.1, 0.0, 0.05), 0.1), sample_meshes.ball((0.0, 0.0, 1.0), 0.1)
    )
    edges = np.stack(face_edges(mesh.corner_vertices, mesh.face_sizes), axis=1)
    fine = RestMesh(mesh.positions, edges, mesh.corner_vertices, mesh.face_sizes)
    n, n_ball = len(POINTS), (len(mesh.positions) - len(POINTS)) // 2
    on_sheet, far = range(n, n + n_ball), range(n + n_ball, n + 2 * n_ball)
    of_sheet, of_ball = PulledPatch(disc(0.0, 0.0, 0.21), 0.5), PulledPatch(np.array([n + 3], dtype=np.int32), 0.3)
    for grab, use_loose_parts, held in ((of_sheet, True, {*far}), (of_sheet, False, {*on_sheet, *far}),
                                     (of_ball, True, {*range(n), *far})):  # fmt: skip
        hold = hold_of_rest(fine, [grab], use_loose_parts=use_loose_parts)
        of_others = {*range(n, n + 2 * n_ball)} if grab is of_sheet else {*range(n), *far}
        assert set(hold.vertices.tolist()) & of_others == held


def test_what_is_on_no_limb_keeps_its_reach():
    """The middle of a sheet."""
    (grab,) = with_root(FINE, [PulledPatch(disc(0.0, 0.0, 0.21), 0.5, root=None)])
    assert grab.root == 0.0
    known = hold_of_rest(FINE, [PulledPatch(grab.vertices, 0.5)], use_loose_parts=True)
    np.testing.assert_array_equal(hold_of_rest(FINE, [grab], use_loose_parts=True).weights, known.weights)


@pytest.mark.parametrize(("axes", "n"), [((True, False, False), 1), ((True, False, True), 3), ((True, True, True), 7)])
def test_mirror_signs_are_all_images_but_the_thing_itself(axes, n):
    signs = list(mirror_signs(axes))
    assert len(set(signs)) == len(signs) == n
    assert ITSELF not in signs


def test_mirror_images_are_where_the_mirror_says():
    vertices = disc(0.5, 0.3, 0.2)
    images = mirror_images(POINTS, EDGES, vertices, (-1.0, 1.0, 1.0))
    expected = {tuple(place) for place in np.round(POINTS[vertices] * (-1.0, 1.0, 1.0), 6)}
    assert {tuple(place) for place in np.round(POINTS[images], 6)} == expected


def test_mirror_images_bear_noise_far_below_the_size_of_faces():
    noisy = POINTS + np.random.default_rng(3).uniform(-1e-5, 1e-5, POINTS.shape)
    vertices = disc(0.5, 0.3, 0.2)
    np.testing.assert_array_equal(
        mirror_images(noisy, EDGES, vertices, (-1.0, 1.0, 1.0)),
        mirror_images(POINTS, EDGES, vertices, (-1.0, 1.0, 1.0)),
    )


@pytest.mark.parametrize("side", [0, 1])
def test_of_surfaces_that_touch_the_image_is_on_the_one_that_was_grabbed(side):
    """Two sheets that have the row y = -1 in common: the other turns up from there, and no edge joins them."""
    sheets = POINTS, np.column_stack([POINTS[:, 0], np.full(N * N, -1.0), POINTS[:, 1] + 1.0])
    points, edges = np.concatenate(sheets), np.concatenate([EDGES, EDGES + N * N])
    seed = np.flatnonzero((points == (0.5, -1.0, 0.0)).all(axis=1))[side : side + 1]
    vertices = connected_within(points, edges, seed, points[seed[0]], 0.25)
    images = mirror_images(points, edges, vertices, (-1.0, 1.0, 1.0))
    mirrored = vertices // N * N + N - 1 - vertices % N
    np.testing.assert_array_equal(images, np.sort(mirrored))


def test_a_mesh_without_mirror_images_is_refused():
    lopsided = POINTS * np.where(POINTS[:, :1] > 0.0, 1.07, 1.0)
    with pytest.raises(ValueError, match=r"^is not symmetric here: turn off Mirror X$"):
        symmetric_grabs(lopsided, EDGES, PulledPatch(disc(0.5, 0.3, 0.2), 1.0), (True, False, False))


def test_an_image_moves_as_the_mirror_image_does():
    vertices = disc(0.5, 0.3, 0.2)
    grabs = symmetric_grabs(POINTS, EDGES, PulledPatch(vertices, 1.0), (True, False, False))
    assert [len(grab.vertices) for grab in grabs] == [len(vertices)] * 2
    wanted = motion(rotation_z(0.4), (0.1, 0.2, 0.3))
    own, image = (grab.motion(wanted, POINTS[vertices].mean(axis=0), np.eye(3)) for grab in grabs)
    np.testing.assert_array_equal(own, wanted)
    flip = np.array([-1.0, 1.0, 1.0])
    for point in POINTS[vertices]:
        np.testing.assert_allclose((image @ [*(point * flip), 1.0])[:3], (own @ [*point, 1.0])[:3] * flip, atol=1e-12)


@pytest.mark.parametrize("stretch", [np.eye(3), np.diag([2.0, 1.0, 0.5])])
def test_what_lies_on_the_plane_stays_on_it(stretch):
    vertices = disc(0.1, 0.3, 0.25)
    (grab,) = symmetric_grabs(POINTS, EDGES, PulledPatch(vertices, 1.0), (True, False, False))
    assert set(vertices.tolist()) < set(grab.vertices.tolist())
    centre = POINTS[grab.vertices].mean(axis=0)
    unstretch = np.linalg.inv(stretch)
    turn = unstretch @ rotation(0.7 * np.array([0.6, 0.0, 0.8])) @ stretch
    done = grab.motion(motion(turn, (0.3, 0.2, 0.1)), centre, stretch)
    flip = np.diag([-1.0, 1.0, 1.0, 1.0])
    np.testing.assert_allclose(flip @ done @ flip, done, atol=1e-12)
    seen = stretch @ done[:3, :3] @ unstretch
    np.testing.assert_allclose(seen @ seen.T, np.eye(3), atol=1e-12)


def test_on_one_plane_of_two_there_is_one_image_more():
    grabs = symmetric_grabs(POINTS, EDGES, PulledPatch(disc(0.0, 0.5, 0.2), 1.0), (True, True, False))
    assert len(grabs) == 2
    assert (POINTS[grabs[1].vertices][:, 1] < 0.0).all()
