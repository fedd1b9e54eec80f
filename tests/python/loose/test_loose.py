# SPDX-License-Identifier: GPL-3.0-or-later
"""Loose pieces go along with what they sit in. With the real solver."""

import dataclasses

import arap_native
import numpy as np
import pytest
import sample_meshes
from arap_deform.core.background import Cancelled, run
from arap_deform.core.mirror import Mirror
from arap_deform.core.session import Session
from arap_deform.core.session_data import SessionMesh, SessionSettings
from arap_deform.core.targets import HandleSpec
from arap_deform.core.transforms import best_rigid_fit, transformed
from sample_meshes import ball, joined, motion, rotation_z

TUBE = sample_meshes.tube(rings=30, segments=16)
BOTTOM = np.flatnonzero(TUBE.positions[:, 2] == 0.0)
TOP = np.flatnonzero(TUBE.positions[:, 2] == 4.0)
EYE = ball((0.4, 0.0, 3.4), 0.2)
PUPIL = ball((0.62, 0.0, 3.4), 0.05)
FAR = ball((3.0, 0.0, 2.0), 0.3)
STRETCH = np.diag([1.0, 2.0, 0.5])
SETTINGS = SessionSettings(rigidity_radius=0.06, accuracy=1e-8, max_iterations=3000)
TURN = motion(np.array([[1.0, 0.0, 0.0], [0.0, 0.6, -0.8], [0.0, 0.8, 0.6]]), (0.2, 1.5, -0.5))


def hold(vertices, **options):
    return HandleSpec("Hold", np.asarray(vertices, np.int32), np.ones(len(vertices)), **options)


HOLDS = [hold(BOTTOM), hold(TOP)]


def rows(*meshes):
    """The vertices of each, joined one after the other."""
    ends = np.cumsum([len(mesh.positions) for mesh in meshes])
    return [np.arange(end - len(mesh.positions), end) for mesh, end in zip(meshes, ends, strict=True)]


def bound(*meshes, stretch=None, settings=SETTINGS, specs=HOLDS, **options):
    mesh = SessionMesh(*joined(*meshes))
    session = run(Session.bind(arap_native, mesh, np.eye(3) if stretch is None else stretch, settings, **options))
    run(session.set_handles(specs))
    return session


def solve(session, *matrices):
    return session.update(np.array(matrices), initial_guess="handle_rotations", to_convergence=True)


def motion_of(rest, shown, stretch=None):
    """The rigid motion that takes (k, 3) ``rest`` to ``shown``; it must take them there exactly."""
    stretch = np.eye(3) if stretch is None else stretch
    fit = best_rigid_fit(rest, shown.astype(float), stretch)
    np.testing.assert_allclose(transformed(fit, rest), shown, atol=1e-6 * TUBE.diagonal)
    return fit


@pytest.mark.parametrize("stretch", [np.eye(3), STRETCH], ids=["unscaled", "scaled"])
def test_what_it_follows_moves_rigidly_and_so_does_it(stretch):
    scale = motion(stretch)
    together = np.linalg.inv(scale) @ motion(rotation_z(0.7), (1.0, -2.0, 0.5)) @ scale
    session = bound(TUBE, EYE, stretch=stretch)
    assert solve(session, together, together).parts_at_rest == 0
    rest = joined(TUBE, EYE).positions
    np.testing.assert_allclose(session.positions, transformed(together, rest), atol=2e-6 * TUBE.diagonal)


@pytest.mark.parametrize("stretch", [np.eye(3), STRETCH], ids=["unscaled", "scaled"])
def test_in_a_bend_it_keeps_its_shape_and_its_place_in_the_surface(stretch):
    session = bound(TUBE, EYE, stretch=stretch)
    solve(session, np.eye(4), TURN)
    of_tube, of_eye = rows(TUBE, EYE)
    fit = motion_of(EYE.positions, session.positions[of_eye], stretch)
    near = np.linalg.norm(TUBE.positions - (0.5, 0.0, 3.4), axis=1) < 0.4
    around = best_rigid_fit(TUBE.positions[near], session.positions[of_tube[near]].astype(float), stretch)
    middle = EYE.positions.mean(axis=0)
    assert np.linalg.norm(transformed(fit, middle) - middle) > 1.0
    np.testing.assert_allclose(transformed(fit, middle), transformed(around, middle), atol=0.1)


def test_the_others_are_posed_as_without_it():
    with_it, without = (
        bound(TUBE, EYE, FAR),
        bound(TUBE, EYE, FAR, settings=dataclasses.replace(SETTINGS, use_loose_parts=False)),
    )
    at_rest = [solve(session, np.eye(4), TURN).parts_at_rest for session in (with_it, without)]
    assert at_rest == [1, 2]
    of_tube, of_eye, of_far = rows(TUBE, EYE, FAR)
    assert np.array_equal(with_it.positions[of_tube], without.positions[of_tube])
    assert np.array_equal(with_it.positions[of_far], FAR.positions.astype(np.float32))
    assert np.array_equal(without.positions[of_eye], EYE.positions.astype(np.float32))


def test_a_piece_with_a_pin_follows_that_alone():
    _, of_eye = rows(TUBE, EYE)
    session = bound(TUBE, EYE, specs=[*HOLDS, hold(of_eye[:3])])
    assert solve(session, np.eye(4), TURN, np.eye(4)).parts_at_rest == 0
    np.testing.assert_allclose(session.positions[of_eye], EYE.positions, atol=1e-6)


def test_at_rest_nothing_moves():
    session = bound(TUBE, EYE, PUPIL)
    solve(session, np.eye(4), np.eye(4))
    np.testing.assert_allclose(session.positions, joined(TUBE, EYE, PUPIL).positions, atol=1e-6)


def test_what_is_inside_a_loose_piece_moves_with_it_as_one_body():
    _, of_eye, of_pupil = rows(TUBE, EYE, PUPIL)
    session = bound(TUBE, EYE, PUPIL)
    assert solve(session, np.eye(4), TURN).parts_at_rest == 0
    both = np.concatenate([of_eye, of_pupil])
    motion_of(joined(EYE, PUPIL).positions, session.positions[both])


def test_what_is_near_nothing_held_goes_with_the_loose_piece_that_it_touches():
    """A string of beads on the tube, the last ones far from it."""
    beads = [ball((0.55 + 0.19 * i, 0.0, 3.4), 0.1) for i in range(6)]
    session = bound(TUBE, *beads)
    assert solve(session, np.eye(4), TURN).parts_at_rest == 0
    motion_of(joined(*beads[1:]).positions, session.positions[np.concatenate(rows(TUBE, *beads)[2:])])


def test_a_piece_larger_than_what_is_held_stays():
    _, of_eye = rows(TUBE, EYE)
    session = bound(TUBE, EYE, specs=[hold(of_eye)])
    assert solve(session, TURN).parts_at_rest == 1
    np.testing.assert_allclose(session.positions[: len(TUBE.positions)], TUBE.positions, atol=1e-6)


def test_a_neighbour_of_the_same_size_stays_but_what_lies_around_follows():
    beside, around = ball((0.0, 0.0, 0.41), 0.2), ball((0.0, 0.0, 0.0), 0.199)
    held = ball((0.0, 0.0, 0.0), 0.2)
    of_held, of_beside, of_around = rows(held, beside, around)
    session = bound(held, beside, around, specs=[hold(of_held)])
    assert solve(session, TURN).parts_at_rest == 1
    np.testing.assert_allclose(session.positions[of_beside], beside.positions, atol=1e-6)
    np.testing.assert_allclose(session.positions[of_around], transformed(TURN, around.positions), atol=1e-5)


def test_what_is_very_far_away_changes_nothing():
    stray = ball((-1e6, 0.0, 0.0), 0.1)
    session, without = bound(TUBE, EYE, stray), bound(TUBE, EYE)
    of_eye, of_stray = rows(TUBE, EYE, stray)[1:]
    for each in (session, without):
        solve(each, TURN, TURN)
    np.testing.assert_allclose(session.positions[of_eye], transformed(TURN, EYE.positions), atol=0.2)
    assert len(session._loose._binding.vertices) == len(EYE.positions)
    np.testing.assert_allclose(session.positions[of_stray], stray.positions, rtol=1e-6)


@pytest.mark.parametrize("n", [2, 20, 60])
def test_a_button_goes_with_the_face_below_it_however_large_that_is(n):
    cloth = sample_meshes.sheet(n)
    button = ball((0.3, 0.2, 0.03), 0.02)
    right = np.flatnonzero(cloth.positions[:, 0] == 1.0)
    left = np.flatnonzero(cloth.positions[:, 0] == -1.0)
    session = bound(cloth, button, specs=[hold(left), hold(right)])
    turn = motion(np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]]))
    solve(session, turn, turn)
    of_button = rows(cloth, button)[1]
    np.testing.assert_allclose(session.positions[of_button], transformed(turn, button.positions), atol=1e-5)


def test_thousands_of_pieces_each_go_with_their_own_place():
    places = np.random.default_rng(5).uniform(-0.9, 0.9, size=(3000, 2))
    cloth = sample_meshes.sheet(41)
    bead = ball((0.0, 0.0, 0.0), 0.01, rings=3, segments=4)
    beads = [bead._replace(positions=np.add(bead.positions, (x, y, 0.01))) for x, y in places]
    sides = [np.flatnonzero(cloth.positions[:, 0] == x) for x in (-1.0, 1.0)]
    settings = dataclasses.replace(SETTINGS, accuracy=1e-5)
    session = bound(cloth, *beads, specs=[hold(side) for side in sides], settings=settings)
    stats = solve(session, np.eye(4), motion(shift=(-0.6, 0.0, 0.4)))
    assert stats.parts_at_rest == 0
    shown = session.positions[len(cloth.positions) :].reshape(3000, -1, 3).astype(float)
    rest = joined(*beads).positions.reshape(3000, -1, 3)
    lengths = [np.linalg.norm(points[:, 1:] - points[:, :1], axis=2) for points in (rest, shown)]
    np.testing.assert_allclose(*lengths, atol=1e-6)
    nearest = np.rint((places + 1.0) * 20.0).astype(int) @ (1, 41)
    below = session.positions[nearest] - cloth.positions[nearest]
    assert np.linalg.norm(shown.mean(axis=1) - rest.mean(axis=1) - below, axis=1).max() < 0.06


def test_shells_of_one_rigid_body_stay_one():
    shells = ball((0.4, 0.0, 3.4), 0.2), ball((0.4, 0.0, 2.0), 0.2)
    of_shells = np.concatenate(rows(TUBE, *shells)[1:])
    regions = np.full(len(joined(TUBE, *shells).positions), -1, np.int32)
    regions[of_shells] = 0
    session = bound(TUBE, *shells, rigid_regions=regions)
    assert solve(session, np.eye(4), TURN).parts_at_rest == 0
    motion_of(joined(*shells).positions, session.positions[of_shells])


def test_the_pose_does_not_depend_on_the_way_to_it():
    session, fresh = bound(TUBE, EYE, FAR), bound(TUBE, EYE, FAR)
    solve(fresh, np.eye(4), TURN)
    solve(session, np.eye(4), motion(shift=(1.0, 0.0, 1.0)))
    session.reset()
    assert np.array_equal(session.positions, joined(TUBE, EYE, FAR).positions.astype(np.float32))
    solve(session, np.eye(4), TURN)
    assert np.array_equal(session.positions, fresh.positions)
    session.reset()
    session.set_positions(fresh.positions)
    assert np.array_equal(session.positions, fresh.positions)
    session.update(np.array([np.eye(4), TURN]), iterations=1)
    np.testing.assert_allclose(session.positions, fresh.positions, atol=1e-5)


def test_a_cancelled_solve_moves_no_loose_piece():
    session = bound(TUBE, EYE)
    solve(session, np.eye(4), TURN)
    before = session.positions.copy()
    with pytest.raises(Cancelled):
        session.update(np.array([np.eye(4), np.eye(4)]), to_convergence=True, progress=lambda _: False)
    assert np.array_equal(session.positions, before)


def test_it_goes_on_from_the_pose_that_is_shown():
    """A pull begins with any pose: also one in which the pieces have not followed."""
    _, of_eye, _ = rows(TUBE, EYE, FAR)
    first = bound(TUBE, EYE, FAR)
    solve(first, np.eye(4), TURN)
    shown = first.positions.copy()
    shown[of_eye] += (0.1, 0.2, 0.3)
    session = bound(TUBE, EYE, FAR)
    run(session.set_handles([hold(BOTTOM, base=shown), hold(TOP, base=shown)], shown))
    session.set_positions(shown)
    solve(session, np.eye(4), np.eye(4))
    np.testing.assert_allclose(session.positions[of_eye], shown[of_eye], atol=1e-5)
    solve(session, TURN, TURN)
    np.testing.assert_allclose(session.positions[of_eye], transformed(TURN, shown[of_eye]), atol=2e-5)


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)])
def test_other_loose_pieces_are_looked_for_when_the_pins_change(shift):
    _, of_eye, of_pupil = rows(TUBE, EYE, PUPIL)
    session = bound(TUBE, EYE, PUPIL)
    solve(session, np.eye(4), TURN)
    run(session.set_handles([*HOLDS, hold(of_eye)]))
    solve(session, np.eye(4), TURN, motion(shift=shift))
    np.testing.assert_allclose(session.positions[of_pupil], PUPIL.positions + shift, atol=1e-5)


def test_a_piece_on_a_mirror_plane_stays_on_it():
    """Half a tube, half an eye on the plane x = 0, and an eye beside it."""
    middle, side = ball((0.0, 0.5, 3.0), 0.2), ball((0.45, 0.2, 2.0), 0.15)
    halves = [half_of(mesh) for mesh in (TUBE, middle, side)]
    bottom, top = (np.flatnonzero(halves[0].positions[:, 2] == z) for z in (0.0, 4.0))
    plane = Mirror(np.diag([-1.0, 1.0, 1.0, 1.0]), 1e-4)
    session = bound(*halves, specs=[hold(bottom), hold(top)], mirrors=[plane])
    up = motion(np.array(TURN[:3, :3]), (0.0, 1.5, -0.5))
    assert solve(session, np.eye(4), up).parts_at_rest == 0
    _, of_middle, of_side = rows(*halves)
    is_on = np.abs(halves[1].positions[:, 0]) < 1e-9
    assert is_on.sum() > 4
    np.testing.assert_allclose(session.positions[of_middle[is_on], 0], 0.0, atol=2e-6)
    for mesh, vertices in ((halves[1], of_middle), (halves[2], of_side)):
        fit = motion_of(mesh.positions, session.positions[vertices])
        assert np.abs(fit - np.eye(4)).max() > 0.1


def half_of(mesh):
    """The faces at x >= 0."""
    starts = np.cumsum(mesh.face_sizes) - mesh.face_sizes
    is_kept = np.minimum.reduceat(mesh.positions[mesh.corner_vertices, 0], starts) > -1e-9
    used, corners = np.unique(mesh.corner_vertices[np.repeat(is_kept, mesh.face_sizes)], return_inverse=True)
    return sample_meshes.Mesh(mesh.positions[used], corners.astype(np.int32), mesh.face_sizes[is_kept])


def test_a_mesh_with_nothing_near_stays_as_it_is():
    session = bound(TUBE, FAR)
    assert solve(session, np.eye(4), TURN).parts_at_rest == 1
    assert np.array_equal(session.positions[len(TUBE.positions) :], FAR.positions.astype(np.float32))
