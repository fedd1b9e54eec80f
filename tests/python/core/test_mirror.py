# SPDX-License-Identifier: GPL-3.0-or-later
"""Half a mesh with mirror planes is posed as the whole one. With the real solver."""

import dataclasses

import arap_native
import numpy as np
import pytest
from arap_deform.core.background import run
from arap_deform.core.graph import face_edges
from arap_deform.core.mirror import Mirror, MirroredMesh, are_same, used_mirrors
from arap_deform.core.session import Session
from arap_deform.core.session_data import SessionMesh, SessionSettings
from arap_deform.core.targets import HandleSpec, Segment
from sample_meshes import motion, rotation_z, tube

TUBE = tube(rings=40, segments=24)
SETTINGS = SessionSettings(rigidity_radius=0.06, accuracy=1e-8, max_iterations=3000)
STRETCH = np.diag([1.0, 2.0, 0.5])
UP, ALONG = motion(shift=(0.3, 0.2, 0.4)), motion(shift=(0.0, 0.4, 0.3))
TURN = motion(rotation_z(0.5), (0.2, 0.1, 0.5))


def flip(axis):
    matrix = np.eye(4)
    matrix[axis, axis] = -1.0
    return matrix


def mirrors(*axes):
    return [Mirror(flip(axis), 1e-3) for axis in axes]


def part_of(mesh, axes):
    """The faces on the positive sides, and the vertices of the whole mesh that they have."""
    starts = np.cumsum(mesh.face_sizes) - mesh.face_sizes
    is_kept = np.ones(len(mesh.face_sizes), dtype=bool)
    for axis in axes:
        is_kept &= np.minimum.reduceat(mesh.positions[mesh.corner_vertices, axis], starts) > -1e-9
    used, corners = np.unique(mesh.corner_vertices[np.repeat(is_kept, mesh.face_sizes)], return_inverse=True)
    return SessionMesh(mesh.positions[used], corners.astype(np.int32), mesh.face_sizes[is_kept]), used


def open_tube(rings, segments):
    """A tube without caps: a plane cuts no face of it."""
    mesh = tube(rings, segments)
    return mesh._replace(corner_vertices=mesh.corner_vertices[: -2 * segments], face_sizes=mesh.face_sizes[:-2])


OPEN = open_tube(40, 24)
WHOLE_MESH = SessionMesh(OPEN.positions, OPEN.corner_vertices, OPEN.face_sizes)


def hold(vertices, weight=1.0, *, use_exact=False):
    return HandleSpec("Hold", np.asarray(vertices, np.int32), np.full(len(vertices), weight), use_exact)


def ring(mesh, z):
    return np.flatnonzero(np.abs(mesh.rest_positions[:, 2] - z) < 0.06)


def posed(mesh, specs, matrices, planes=(), stretch=None, settings=SETTINGS):
    session = run(Session.bind(arap_native, mesh, np.eye(3) if stretch is None else stretch, settings, mirrors=planes))
    run(session.set_handles(specs))
    session.update(np.array(matrices), initial_guess="rest", to_convergence=True)
    return session, session.positions.astype(float)


def spot(mesh, place, distance=0.25):
    return np.flatnonzero(np.linalg.norm(mesh.rest_positions - place, axis=1) < distance)


@pytest.mark.parametrize("stretch", [np.eye(3), STRETCH], ids=["unscaled", "scaled"])
def test_a_half_is_posed_as_the_whole_with_mirrored_handles(stretch):
    half, used = part_of(OPEN, [0])
    side, other = np.array([0.5, 0.0, 2.0]), np.array([-0.5, 0.0, 2.0])
    opposite = flip(0) @ TURN @ flip(0)
    session, positions = posed(
        half,
        [hold(ring(half, 0.0), use_exact=True), hold(spot(half, side)), hold(ring(half, 4.0))],
        [np.eye(4), TURN, ALONG],
        mirrors(0),
        stretch,
    )
    _, expected = posed(
        WHOLE_MESH,
        [hold(ring(WHOLE_MESH, 0.0), use_exact=True), hold(spot(WHOLE_MESH, side)), hold(spot(WHOLE_MESH, other)),
         hold(ring(WHOLE_MESH, 4.0))],
        [np.eye(4), TURN, opposite, ALONG],
        stretch=stretch,
    )  # fmt: skip
    np.testing.assert_allclose(positions, expected[used], atol=1e-4 * TUBE.diagonal)
    is_on = np.abs(half.rest_positions[:, 0]) < 1e-6
    np.testing.assert_allclose(positions[is_on, 0], 0.0, atol=1e-6)
    assert np.abs(positions[is_on] - half.rest_positions[is_on]).max() > 0.1
    assert session.n_vertices == len(half.rest_positions)


def test_what_touches_the_plane_moves_along_it():
    half, _ = part_of(OPEN, [0])
    top = ring(half, 4.0)
    turn = motion(rotation_z(0.3), (0.4, 0.2, 0.1))
    _, positions = posed(half, [hold(ring(half, 0.0), use_exact=True), hold(top)], [np.eye(4), turn], mirrors(0))
    moved = positions[top] - half.rest_positions[top]
    np.testing.assert_allclose(moved, np.tile([0.0, 0.2, 0.1], (len(top), 1)), atol=1e-5)  # the turn is undone, too


def test_a_scale_of_what_touches_the_plane_is_kept():
    half, _ = part_of(OPEN, [0])
    top = ring(half, 4.0)
    wide = motion(np.diag([2.0, 1.5, 1.0]))
    _, positions = posed(half, [hold(ring(half, 0.0), use_exact=True), hold(top)], [np.eye(4), wide], mirrors(0))
    np.testing.assert_allclose(positions[top], half.rest_positions[top] * (2.0, 1.5, 1.0), atol=1e-5)


def test_a_quarter_is_posed_as_the_whole():
    quarter, used = part_of(OPEN, [0, 1])
    side = np.array([0.5, 0.0, 2.0])  # on the plane of y
    _, positions = posed(
        quarter,
        [hold(ring(quarter, 0.0), use_exact=True), hold(spot(quarter, side))],
        [np.eye(4), UP],
        mirrors(0, 1),
    )
    along = motion(shift=(0.3, 0.0, 0.4))
    _, expected = posed(
        WHOLE_MESH,
        [
            hold(ring(WHOLE_MESH, 0.0), use_exact=True),
            hold(spot(WHOLE_MESH, side)),
            hold(spot(WHOLE_MESH, -side * (1, 1, -1))),
        ],
        [np.eye(4), along, flip(0) @ along @ flip(0)],
    )
    np.testing.assert_allclose(positions, expected[used], atol=1e-4 * TUBE.diagonal)


def test_soft_holds_keep_what_is_on_the_plane_on_it():
    half, _ = part_of(OPEN, [0])
    _, positions = posed(
        half, [hold(ring(half, 0.0), use_exact=True), hold(ring(half, 4.0), 0.5)], [np.eye(4), UP], mirrors(0)
    )
    np.testing.assert_allclose(positions[np.abs(half.rest_positions[:, 0]) < 1e-6, 0], 0.0, atol=1e-6)


def image_of(mesh, vertices):
    images = mesh.positions[vertices] * (-1.0, 1.0, 1.0)
    return np.array([np.linalg.norm(mesh.positions - image, axis=1).argmin() for image in images])


def test_thin_parts_that_the_plane_cuts_are_seen_whole():
    """The walls of a flat tube are linked through the plane: the links are images of each other."""
    flat = OPEN._replace(positions=OPEN.positions * (0.1, 1.0, 1.0))
    half, used = part_of(flat, [0])
    whole_mesh = SessionMesh(flat.positions, flat.corner_vertices, flat.face_sizes)
    place = spot(half, np.array([0.05, 0.0, 2.0]), 0.1)
    press = motion(shift=(0.1, 0.0, 0.2))
    _, positions = posed(half, [hold(ring(half, 0.0), use_exact=True), hold(place)], [np.eye(4), press], mirrors(0))
    _, expected = posed(
        whole_mesh,
        [hold(ring(whole_mesh, 0.0), use_exact=True), hold(used[place]), hold(image_of(flat, used[place]))],
        [np.eye(4), press, flip(0) @ press @ flip(0)],
    )
    np.testing.assert_allclose(positions, expected[used], atol=1e-3 * TUBE.diagonal)


def test_which_planes_complete_a_mesh():
    half, _ = part_of(OPEN, [0])
    quarter, _ = part_of(OPEN, [0, 1])
    away = dataclasses.replace(half, rest_positions=np.add(half.rest_positions, (0.1, 0.0, 0.0)))
    shear = np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 1.0]])
    for mesh, axes, stretch, n in (
        (half, (0,), np.eye(3), 1),
        (half, (0,), STRETCH, 1),
        (half, (0,), shear, 0),  # the image looks different
        (half, (1,), np.eye(3), 0),  # on both sides of the plane
        (away, (0,), np.eye(3), 0),  # nothing to join
        (quarter, (0, 1), np.eye(3), 2),
        (WHOLE_MESH, (0,), np.eye(3), 0),
    ):
        assert len(used_mirrors(mirrors(*axes), mesh.rest_positions, stretch)) == n


def test_a_plane_is_the_same_but_for_rounding_and_the_merge_distance():
    moved = flip(0)
    moved[0, 3] = 1e-7
    assert are_same(mirrors(0), [Mirror(moved, 1e-3)])
    assert not are_same(mirrors(0), [Mirror(flip(0), 2e-3)])
    assert not are_same(mirrors(0), mirrors(1))
    assert not are_same(mirrors(0), [])


def test_rounding_grows_with_the_size_of_coordinates():
    """Far from the origin, single precision moves the plane, and the vertices on it, by more."""
    half, _ = part_of(OPEN, [0])
    away = np.add(half.rest_positions, (0.003, 0.0, 0.0))
    moved = flip(0)
    moved[0, 3] = 0.01
    for size, n in ((0.0, 0), (1e4, 1)):
        assert len(used_mirrors([Mirror(flip(0), 1e-3, size)], away, np.eye(3))) == n
        assert are_same([Mirror(flip(0), 1e-3, size)], [Mirror(moved, 1e-3, size)]) == bool(n)
    far = flip(0)
    far[0, 3] = 2e4
    assert len(used_mirrors([Mirror(far, 1e-3)], np.add(away, (1e4, 0.0, 0.0)), np.eye(3))) == 1


def test_the_whole_is_closed_and_what_is_near_the_plane_is_put_on_it():
    half, _ = part_of(OPEN, [0])
    is_on = np.abs(half.rest_positions[:, 0]) < 1e-6
    half.rest_positions[is_on, 0] = 4e-4
    whole = MirroredMesh(half, mirrors(0), np.eye(3))
    assert len(whole.sources) == len(OPEN.positions)
    assert len(whole.mesh.corner_vertices) == len(OPEN.corner_vertices)
    np.testing.assert_array_equal(whole.mesh.rest_positions[: len(is_on)][is_on, 0], 0.0)
    np.testing.assert_allclose(whole.lifted(half.rest_positions), whole.mesh.rest_positions, atol=1e-12)
    first, second = face_edges(whole.mesh.corner_vertices, whole.mesh.face_sizes)
    sides = set(zip(first.tolist(), second.tolist(), strict=True))
    assert len(sides) == len(first), "neighbouring faces run the same way around"


def test_a_face_in_the_plane_is_there_once():
    wall = SessionMesh(
        np.array([[0.0, 0, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1], [1, 0, 0]]),
        np.array([0, 1, 2, 3, 0, 1, 4], np.int32),
        np.array([4, 3], np.int32),
    )
    whole = MirroredMesh(wall, mirrors(0), np.eye(3))
    assert whole.mesh.face_sizes.tolist() == [4, 3, 3]
    assert whole.mesh.corner_vertices.tolist() == [0, 1, 2, 3, 0, 1, 4, 5, 1, 0]


def test_a_rigid_region_at_the_plane_is_one_body_with_its_image():
    half, _ = part_of(OPEN, [0])
    regions = np.full(len(half.rest_positions), -1, np.int32)
    regions[ring(half, 2.0)] = 0
    regions[spot(half, np.array([0.5, 0.0, 3.0]))] = 1
    whole = MirroredMesh(half, mirrors(0), np.eye(3))
    of_whole = whole.regions(regions)
    assert sorted(set(of_whole.tolist())) == [-1, 0, 1, 3]
    assert (of_whole == 0).sum() == len(ring(WHOLE_MESH, 2.0))
    assert (of_whole == 1).sum() == (of_whole == 3).sum() == (regions == 1).sum()
    assert whole.regions(None) is None


def test_a_part_at_rest_is_counted_without_its_image():
    half, _ = part_of(OPEN, [0])
    n = len(half.rest_positions)
    shifts = [(0.0, 0.0, 0.0), (9.0, 0.0, 0.0), (0.0, 9.0, 0.0)]  # held, away from the plane, on the plane
    parts = SessionMesh(
        np.concatenate([np.add(half.rest_positions, shift) for shift in shifts]),
        np.concatenate([half.corner_vertices + i * n for i in range(3)]).astype(np.int32),
        np.tile(half.face_sizes, 3),
    )
    session, _ = posed(parts, [hold(ring(half, 0.0))], [np.eye(4)], mirrors(0))
    assert session.update(np.eye(4)[None]).parts_at_rest == 2


def test_a_bone_on_one_side_has_an_image_and_one_on_the_plane_has_none():
    half, _ = part_of(OPEN, [0])
    whole = MirroredMesh(half, mirrors(0), np.eye(4)[:3, :3])
    nothing = np.empty(0, np.int32), np.empty(0)
    beside = HandleSpec("Beside", *nothing, segment=Segment(np.array([[0.2, 0.0, 1.0], [0.3, 0.0, 2.0]])))
    on_plane = HandleSpec("Middle", *nothing, segment=Segment(np.array([[0.0, 0.1, 1.0], [0.0, 0.0, 2.0]])))
    specs, copies = whole.specs([beside, on_plane])
    assert [(copy.handle, copy.image) for copy in copies] == [(0, 0), (0, 1), (1, 0)]
    assert specs[1].segment is not None
    np.testing.assert_allclose(specs[1].segment.ends, [[-0.2, 0.0, 1.0], [-0.3, 0.0, 2.0]], atol=1e-12)
    turn = motion(rotation_z(0.4), (0.1, 0.2, 0.3))
    of_copies = whole.matrices(np.array([turn, turn]), copies)
    np.testing.assert_allclose(of_copies[1], flip(0) @ turn @ flip(0), atol=1e-12)
    np.testing.assert_allclose(of_copies[2], flip(0) @ of_copies[2] @ flip(0), atol=1e-12)
