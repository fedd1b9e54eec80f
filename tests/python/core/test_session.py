# SPDX-License-Identifier: GPL-3.0-or-later
"""A session: handles move, the mesh follows. With the real solver, without Blender."""

import dataclasses
import re
from itertools import pairwise

import arap_native
import numpy as np
import pytest
from arap_deform.core.background import Background, Cancelled, run
from arap_deform.core.session import Session
from arap_deform.core.session_data import SessionMesh, SessionSettings, stats_of_whole
from arap_deform.core.stiffness import StiffGroup, regions_of, stiffness_of
from arap_deform.core.targets import HandleSpec, Segment
from arap_deform.core.transforms import best_rigid_fit, stretch_of
from sample_meshes import motion, rotation_z, sheet, tube

TUBE = tube()
MESH = SessionMesh(TUBE.positions, TUBE.corner_vertices, TUBE.face_sizes)
BOTTOM = np.flatnonzero(TUBE.positions[:, 2] == 0.0).astype(np.int32)
TOP = np.flatnonzero(TUBE.positions[:, 2] == 4.0).astype(np.int32)
STRETCH = np.diag([1.0, 3.0, 0.5])
NO_MOTION = np.eye(4)
EXACT = SessionSettings(accuracy=1e-10, max_iterations=2000)


def rotation_x(angle_rad):
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def apply(matrix, points):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def group(vertices, weight=1.0, name="Group"):
    return HandleSpec(name, vertices, np.full(len(vertices), weight))


def new_session(stretch=None, settings=EXACT, specs=None, mesh=MESH, **properties):
    session = run(Session.bind(arap_native, mesh, np.eye(3) if stretch is None else stretch, settings, **properties))
    run(session.set_handles(specs or [group(BOTTOM, name="Feet"), group(TOP, name="Head")]))
    return session


BEND = motion(rotation_x(0.9), (0.0, 1.0, -0.5))


def test_positions_are_single_precision_and_stay_the_same_array():
    session = new_session()
    positions = session.positions
    session.update(np.array([NO_MOTION, BEND]))
    assert session.positions is positions
    assert positions.dtype == np.float32
    assert positions.flags.c_contiguous
    np.testing.assert_allclose(positions[TOP], apply(BEND, TUBE.positions[TOP]), atol=1e-6)


@pytest.mark.parametrize("stretch", [np.eye(3), STRETCH], ids=["unscaled", "scaled"])
def test_handles_that_move_as_one_body_take_the_mesh_along(stretch):
    """Rigid as seen: S^-1 (R, t) S in object space."""
    seen = motion(rotation_z(0.7) @ rotation_x(0.4), (1.0, -2.0, 0.5))
    scale = motion(stretch)
    together = np.linalg.inv(scale) @ seen @ scale
    session = new_session(stretch)
    session.update(np.array([together, together]), initial_guess="handle_rotations", to_convergence=True)
    np.testing.assert_allclose(session.positions, apply(together, TUBE.positions), atol=2e-6 * TUBE.diagonal)


def test_a_scaled_object_deforms_like_a_mesh_of_that_shape():
    """Rigid means rigid as seen: scaling the object, or its mesh, is the same."""
    scaled_mesh = dataclasses.replace(MESH, rest_positions=TUBE.positions @ STRETCH.T)
    of_mesh = new_session(mesh=scaled_mesh)
    of_object = new_session(STRETCH)
    scale = motion(STRETCH)
    in_object = np.linalg.inv(scale) @ BEND @ scale
    energies = [
        of_mesh.update(np.array([NO_MOTION, BEND]), initial_guess="rest", to_convergence=True).energy,
        of_object.update(np.array([NO_MOTION, in_object]), initial_guess="rest", to_convergence=True).energy,
    ]
    np.testing.assert_allclose(of_object.positions @ STRETCH.T, of_mesh.positions, atol=1e-5)
    assert energies[0] == pytest.approx(energies[1], rel=1e-9)
    assert energies[0] > 1e-3


def test_new_targets_never_factorize_and_new_groups_do_once():
    session = new_session()
    before = session.n_factorizations
    for angle in (0.1, 0.2, 0.3):
        session.update(np.array([NO_MOTION, motion(rotation_x(angle))]))
    run(session.set_handles([group(BOTTOM, name="Renamed"), group(TOP)]))
    assert session.n_factorizations == before
    run(session.set_handles([group(BOTTOM), group(TOP, 0.5)]))
    assert session.n_factorizations == before + 1


def test_an_update_goes_on_from_the_last_one():
    settings = dataclasses.replace(EXACT, iterations_per_update=1)
    stepwise, at_once = new_session(settings=settings), new_session(settings=settings)
    matrices = np.array([NO_MOTION, BEND])
    all_stats = [stepwise.update(matrices) for _ in range(30)]
    whole = at_once.update(matrices, iterations=30)
    assert [stats.iterations for stats in all_stats] == [1] * 30
    assert whole.iterations == 30
    assert all_stats[-1].energy == pytest.approx(whole.energy, rel=1e-9), "the search goes on from its end"
    energies = [stats.energy for stats in all_stats]
    assert all(later <= earlier * (1 + 1e-9) for earlier, later in pairwise(energies))
    together = stats_of_whole(all_stats)
    assert together.iterations == 30
    assert together.energy_before == all_stats[0].energy_before
    assert together.energy == all_stats[-1].energy
    assert together.last_ms == pytest.approx(sum(stats.last_ms for stats in all_stats))
    for session in (stepwise, at_once):
        assert session.update(matrices, to_convergence=True).stop_reason == "converged"
    np.testing.assert_allclose(stepwise.positions, at_once.positions, atol=1e-5)


def test_convergence_stops_before_the_limit_and_the_limit_before_convergence():
    matrices = np.array([NO_MOTION, BEND])
    loose = new_session(settings=SessionSettings(accuracy=1e-2, max_iterations=500))
    stats = loose.update(matrices, to_convergence=True)
    assert stats.stop_reason == "converged"
    assert stats.iterations < 500
    short = new_session(settings=dataclasses.replace(EXACT, max_iterations=3))
    stats = short.update(matrices, to_convergence=True)
    assert (stats.stop_reason, stats.iterations) == ("max_iterations", 3)


def test_a_time_limit_stops():
    first = new_session().update(np.array([NO_MOTION, BEND]), to_convergence=True, time_limit_s=1e-9)
    assert (first.stop_reason, first.iterations) == ("time_limit", 1)


def test_less_accuracy_is_enough_if_asked_for():
    matrices = np.array([NO_MOTION, BEND])
    whole = new_session().update(matrices, to_convergence=True)
    followed = new_session().update(matrices, to_convergence=True, sufficient_accuracy=1e-4)
    coarse = new_session(settings=dataclasses.replace(EXACT, accuracy=1e-4))
    assert followed.iterations == coarse.update(matrices, to_convergence=True, sufficient_accuracy=1e-6).iterations
    assert followed.iterations < whole.iterations


def test_readout_counts():
    stats = new_session(specs=[group(BOTTOM), group(TOP, 0.5)]).update(np.array([NO_MOTION, NO_MOTION]))
    assert stats.vertices == len(TUBE.positions)
    assert stats.free_vertices == len(TUBE.positions) - len(BOTTOM) - len(TOP)
    assert stats.parts_at_rest == 0
    assert stats.loose_vertices == 0
    assert min(stats.last_ms, stats.bind_ms, stats.factor_ms) > 0.0


def test_cancelled_solve_changes_nothing():
    session = new_session()
    session.update(np.array([NO_MOTION, motion(rotation_x(0.2))]))
    before = session.positions.copy()
    with pytest.raises(Cancelled, match=r"^Solving was cancelled; the pose is as it was$"):
        session.update(np.array([NO_MOTION, BEND]), to_convergence=True, progress=lambda _: False)
    assert np.array_equal(session.positions, before)


def test_cancelled_bind_and_cancelled_handles_say_so():
    with pytest.raises(Cancelled, match=r"^Binding was cancelled; nothing has changed$"):
        run(Session.bind(arap_native, MESH, np.eye(3), EXACT), lambda _: False)
    session = new_session()
    with pytest.raises(Cancelled, match=r"^Preparing the handles was cancelled; nothing has changed$"):
        run(session.set_handles([group(BOTTOM)]), lambda _: False)
    session.update(np.array([NO_MOTION, BEND]))  # the former handles stay


def wait_unseen(work: Background) -> None:
    """Waits until the job under way is done; the work has not seen that yet."""
    work._stage.job.wait()


@pytest.mark.parametrize("has_ended", [False, True])
def test_dropped_handles_leave_the_former_ones(has_ended):
    session = new_session()
    expected = new_session()
    work = Background(session.set_handles([group(BOTTOM), group(TOP[:4])]))
    if has_ended:
        wait_unseen(work)
    work.drop()
    for each in (session, expected):
        each.update(np.array([NO_MOTION, BEND]), to_convergence=True)
    np.testing.assert_allclose(session.positions, expected.positions, atol=1e-6)


@pytest.mark.parametrize("has_ended", [False, True])
def test_a_dropped_solve_lets_go_of_the_session_at_once(has_ended):
    session = new_session()
    work = Background(session.updating(np.array([NO_MOTION, BEND]), initial_guess="rest", to_convergence=True))
    if has_ended:
        wait_unseen(work)
    work.drop()
    session.reset()
    np.testing.assert_allclose(session.positions, TUBE.positions, atol=1e-6)


def test_in_the_background_it_solves_as_at_once():
    options = {"initial_guess": "handle_rotations", "to_convergence": True}
    matrices = np.array([NO_MOTION, BEND])
    session, other = new_session(STRETCH), new_session(STRETCH)
    stats, expected = run(session.updating(matrices, **options)), other.update(matrices, **options)
    assert np.array_equal(session.positions, other.positions)
    assert (stats.iterations, stats.energy) == (expected.iterations, expected.energy)


def test_reset_and_set_positions():
    session = new_session(STRETCH)
    matrices = np.array([NO_MOTION, motion(shift=(0.0, 0.5, 0.0))])
    session.update(matrices, to_convergence=True)
    posed = session.positions.copy()
    session.reset()
    np.testing.assert_allclose(session.positions, TUBE.positions, atol=1e-6)
    session.set_positions(posed)
    assert np.array_equal(session.positions, posed)
    stats = session.update(matrices, iterations=1)
    assert stats.step < 1e-5  # it goes on from there: nothing is left to do


def test_a_pose_out_of_the_range_of_single_precision_leaves_the_last_one():
    """The solver's numbers are in range, but not those of the object, which is scaled to a billionth."""
    session = new_session(1e-9 * np.eye(3))
    session.update(np.array([NO_MOTION, BEND]), to_convergence=True)
    before = session.positions.copy()
    far = motion(np.eye(3), (1e39, 0.0, 0.0))
    with pytest.raises(RuntimeError, match="too far away for single precision"):
        session.update(np.array([NO_MOTION, far]), initial_guess="handle_rotations", to_convergence=True)
    np.testing.assert_array_equal(session.positions, before)
    session.update(np.array([NO_MOTION, BEND]), to_convergence=True)
    np.testing.assert_allclose(session.positions, before, atol=1e-5)


def test_rigid_regions_and_stiffness_reach_the_solver():
    middle = np.abs(TUBE.positions[:, 2] - 2.0) < 0.8
    weights = {"Middle": middle.astype(float)}
    regions = regions_of([StiffGroup("Middle", use_rigid=True)], weights, MESH)
    session = new_session(rigid_regions=regions)
    session.update(np.array([NO_MOTION, BEND]), initial_guess="rest", to_convergence=True)
    rest, shown = TUBE.positions[middle], session.positions[middle].astype(float)
    fit = best_rigid_fit(rest, shown, np.eye(3))
    np.testing.assert_allclose(apply(fit, rest), shown, atol=1e-5)

    def bent_by(stiffness):
        session = new_session(stiffness=stiffness)
        session.update(np.array([NO_MOTION, BEND]), initial_guess="rest", to_convergence=True)
        shown = session.positions[middle].astype(float)
        return np.abs(apply(best_rigid_fit(rest, shown, np.eye(3)), rest) - shown).max()

    assert bent_by(stiffness_of([StiffGroup("Middle")], weights)) < 0.2 * bent_by(None)


def test_settings_that_need_no_bind_can_change():
    session = new_session()
    session.settings = dataclasses.replace(EXACT, accuracy=1e-2, iterations_per_update=7)
    assert session.update(np.array([NO_MOTION, BEND]), initial_guess="rest").iterations <= 7
    with pytest.raises(ValueError, match=r"^Model, cube size, .* and Loose Pieces Follow are fixed at bind"):
        session.settings = dataclasses.replace(EXACT, energy="spokes")


def test_a_solid_is_bound_again_for_its_own_settings_alone():
    solid = SessionSettings(model="solid")
    assert dataclasses.replace(solid, energy="spokes", rigidity_radius=0.1).of_bind == solid.of_bind
    assert dataclasses.replace(solid, cube_size=0.1).of_bind != solid.of_bind
    assert dataclasses.replace(solid, keep_volume=1.0).of_bind != solid.of_bind
    assert SessionSettings(cube_size=0.1, keep_volume=1.0).of_bind == SessionSettings().of_bind


def test_a_solid_keeps_its_girth_under_a_twist():
    middle = np.flatnonzero(np.abs(TUBE.positions[:, 2] - 2.0) < 0.3)

    def girth(**settings):
        session = new_session(settings=dataclasses.replace(EXACT, **settings))
        for turn in (1.0, 2.0):
            session.update(np.array([NO_MOTION, motion(rotation_z(turn))]), to_convergence=True)
        return np.linalg.norm(session.positions[middle, :2], axis=1).mean()

    assert girth(model="solid") > girth() + 0.02


def test_a_solid_of_a_sheet_says_that_it_has_no_inside():
    flat = sheet(6)
    for mesh, expected in ((MESH, True), (SessionMesh(flat.positions, flat.corner_vertices, flat.face_sizes), False)):
        assert run(Session.bind(arap_native, mesh, np.eye(3), SessionSettings(model="solid"))).has_inside is expected
        assert run(Session.bind(arap_native, mesh, np.eye(3), SessionSettings())).has_inside


def test_a_cloth_beside_a_body_stays_a_surface():
    flat = sheet(6)
    n = len(TUBE.positions)
    both = SessionMesh(
        np.concatenate([TUBE.positions, flat.positions + np.array((4.0, 0.0, 0.0))]),
        np.concatenate([TUBE.corner_vertices, flat.corner_vertices + n]).astype(np.int32),
        np.concatenate([TUBE.face_sizes, flat.face_sizes]),
    )
    session = run(Session.bind(arap_native, both, np.eye(3), SessionSettings(model="solid", cube_size=0.05)))
    assert (session.has_inside, session.n_sheets) == (True, 1)
    assert run(Session.bind(arap_native, both, np.eye(3), SessionSettings())).n_sheets == 0


def bone(low, high, name="Bone"):
    ends = np.array([[0.0, 0.0, low], [0.0, 0.0, high]])
    return HandleSpec(name, np.empty(0, np.int32), np.empty(0), segment=Segment(ends))


def test_bones_move_a_solid_without_vertices():
    specs = [bone(0.1, 2.0), bone(2.0, 3.9, "Upper"), bone(8.0, 9.0, "Far")]
    session = run(Session.bind(arap_native, MESH, np.eye(3), SessionSettings(model="solid")))
    run(session.set_handles(specs))
    stats = session.update(np.array([NO_MOTION, BEND, NO_MOTION]), to_convergence=True)
    assert (stats.outside, stats.parts_at_rest) == (("Far",), 0)
    np.testing.assert_allclose(session.positions[TOP], apply(BEND, TUBE.positions[TOP]), atol=0.05)
    np.testing.assert_allclose(session.positions[BOTTOM], TUBE.positions[BOTTOM], atol=0.05)
    n = session.n_factorizations
    run(session.set_handles([bone(0.1, 2.0), bone(2.0, 3.9, "Upper"), bone(8.0, 9.0, "Far")]))
    assert session.n_factorizations == n
    run(session.set_handles(specs[:1]))
    assert session.n_factorizations == n + 1


def test_bones_outside_alone_are_refused_and_a_surface_has_no_inside():
    solid = run(Session.bind(arap_native, MESH, np.eye(3), SessionSettings(model="solid")))
    with pytest.raises(ValueError, match=r"^No bone passes through the mesh \(A, B, C and 1 more\): move the armature"):
        run(solid.set_handles([bone(8.0, 9.0, name) for name in "ABCD"]))
    surface = run(Session.bind(arap_native, MESH, np.eye(3), SessionSettings()))
    with pytest.raises(ValueError, match=r"^No bone passes through the mesh"):
        run(surface.set_handles([bone(0.1, 2.0)]))


@pytest.mark.parametrize("energy", ["spokes", "spokes_and_rims"])
@pytest.mark.parametrize("weights", ["cotangent", "uniform"])
@pytest.mark.parametrize("guess", ["previous", "rest", "naive_laplacian", "handle_rotations"])
def test_every_setting_reaches_a_pose(energy, weights, guess):
    session = new_session(settings=SessionSettings(energy=energy, weights=weights, initial_guess=guess))
    session.update(np.array([NO_MOTION, BEND]), to_convergence=True)
    np.testing.assert_allclose(session.positions[TOP], apply(BEND, TUBE.positions[TOP]), atol=1e-5)


def test_misuse_is_refused():
    session = run(Session.bind(arap_native, MESH, np.eye(3), EXACT))
    with pytest.raises(ValueError, match=r"^The session has no handles: call set_handles first$"):
        session.update(np.empty((0, 4, 4)))
    shape = re.escape(f"positions have shape (3, 3), expected {TUBE.positions.shape}")
    with pytest.raises(ValueError, match=rf"^{shape}$"):
        session.set_positions(np.zeros((3, 3)))


def test_stretch_is_the_symmetric_factor():
    matrix = motion(rotation_z(1.1) @ rotation_x(0.3), (5.0, 6.0, 7.0))
    matrix[:3, :3] = matrix[:3, :3] @ np.array([[2.0, 0.4, 0.0], [0.4, 1.0, 0.0], [0.0, 0.0, 3.0]])
    stretch = stretch_of(matrix)
    np.testing.assert_allclose(stretch, stretch.T, atol=1e-12)
    rotation = matrix[:3, :3] @ np.linalg.inv(stretch)
    np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), atol=1e-12)


def test_turned_and_mirrored_objects_have_no_stretch():
    single = rotation_z(0.3).astype(np.float32)
    assert np.array_equal(stretch_of(single), np.eye(3))
    assert np.array_equal(stretch_of(np.diag([-1.0, 1.0, 1.0])), np.eye(3))


def test_singular_matrices_are_refused():
    with pytest.raises(ValueError, match=r"^is scaled to nothing along an axis: give it a scale$"):
        stretch_of(np.diag([1.0, 0.0, 1.0]))
    with pytest.raises(ValueError, match=r"^is scaled to nothing along an axis: give it a scale$"):
        stretch_of(np.zeros((4, 4)))
    with pytest.raises(ValueError, match=r"^has a transform that is not finite: reset it$"):
        stretch_of(np.full((3, 3), np.inf))


@pytest.mark.parametrize("stretch", [np.eye(3), STRETCH], ids=["unscaled", "scaled"])
def test_best_rigid_fit_finds_a_rigid_motion(stretch):
    points = np.random.default_rng(3).normal(size=(20, 3))
    scale = motion(stretch)
    truth = np.linalg.inv(scale) @ motion(rotation_z(2.5) @ rotation_x(-1.0), (1.0, 2.0, 3.0)) @ scale
    np.testing.assert_allclose(best_rigid_fit(points, apply(truth, points), stretch), truth, atol=1e-6)


def test_best_rigid_fit_of_a_point_only_shifts_and_of_a_line_turns_least():
    point = np.array([[1.0, 2.0, 3.0]])
    np.testing.assert_allclose(
        best_rigid_fit(point, point + np.array([1.0, 0.0, 0.0]), np.eye(3)), motion(shift=(1.0, 0, 0))
    )
    line = np.outer(np.linspace(-1.0, 1.0, 5), [1.0, 0.0, 0.0])
    fit = best_rigid_fit(line, line @ rotation_z(0.6).T, np.eye(3))
    np.testing.assert_allclose(fit[:3, :3], rotation_z(0.6), atol=1e-6)
