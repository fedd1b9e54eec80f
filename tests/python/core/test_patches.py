# SPDX-License-Identifier: GPL-3.0-or-later
"""Point handles: which handles are points, what they hold, and that the mesh follows it. With the real solver."""

import dataclasses

import arap_native
import numpy as np
import pytest
from arap_deform.core.background import run
from arap_deform.core.patches import PATCH_REACH, surface_diagonal
from arap_deform.core.session import Session
from arap_deform.core.session_data import SessionMesh, SessionSettings
from arap_deform.core.targets import HandleMap, HandleSpec, Patch
from arap_deform.core.transforms import best_rigid_fit
from arap_deform.core.unbound import local_patch, neighbourhood
from sample_meshes import motion, rotation_z, tube

TUBE = tube(rings=60, segments=48)
MESH = SessionMesh(TUBE.positions, TUBE.corner_vertices, TUBE.face_sizes)
SETTINGS = SessionSettings(rigidity_radius=0.05, accuracy=1e-8, max_iterations=1000)
RADIUS = SETTINGS.rigidity_radius * TUBE.diagonal
Z = TUBE.positions[:, 2]
BOTTOM = np.flatnonzero(Z == 0.0).astype(np.int32)
TOP = np.flatnonzero(Z == 4.0).astype(np.int32)
POINT = np.array([30 * 48], np.int32)  # half way up, on the x axis
STRETCH = np.diag([1.0, 2.0, 0.5])
NO_MOTION = np.eye(4)


def shift(x=0.0, y=0.0, z=0.0):
    return motion(shift=(x, y, z))


def hold(vertices, weight=1.0, *, use_exact=False):
    return HandleSpec("Hold", np.asarray(vertices, np.int32), np.full(len(vertices), weight), use_exact)


def new_session(*handles, settings=SETTINGS, stretch=None, mesh=MESH):
    session = run(Session.bind(arap_native, mesh, np.eye(3) if stretch is None else stretch, settings))
    run(session.set_handles([hold(BOTTOM, use_exact=True), *handles]))
    return session


def pulled(session, matrix):
    session.update(np.array([NO_MOTION, matrix]), initial_guess="rest", to_convergence=True)
    return session.positions.astype(float)


def around(point, distance):
    return np.flatnonzero(np.linalg.norm(TUBE.positions - TUBE.positions[point], axis=1) < distance)


@pytest.mark.parametrize("stretch", [np.eye(3), STRETCH], ids=["unscaled", "scaled"])
def test_a_point_holds_the_average_of_its_patch(stretch):
    session = new_session(hold(POINT), stretch=stretch)
    patch = session.patches[1][0]
    assert POINT[0] in patch.vertices
    assert len(patch.vertices) > 10
    assert patch.weights.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(patch.weights @ TUBE.positions[patch.vertices], patch.centre, atol=1e-12)
    move = shift(0.3, 0.1, 0.2)
    positions = pulled(session, move)
    np.testing.assert_allclose(patch.weights @ positions[patch.vertices], patch.centre + move[:3, 3], atol=1e-5)


def test_a_patch_reaches_one_and_a_half_radii_as_seen():
    for stretch in (np.eye(3), STRETCH):
        patch = new_session(hold(POINT), stretch=stretch).patches[1][0]
        seen = TUBE.positions @ stretch.T
        reach = PATCH_REACH * 0.05 * np.linalg.norm(np.ptp(seen, axis=0))
        distance = np.linalg.norm(seen[patch.vertices] - seen[POINT], axis=1)
        assert 0.6 * reach < distance.max() < reach


def test_a_point_at_rest_moves_nothing():
    np.testing.assert_allclose(pulled(new_session(hold(POINT)), NO_MOTION), TUBE.positions, atol=1e-6)


def test_an_exact_handle_pulls_a_spike_and_a_point_a_hill():
    """How far the surface around has come along, as a part of the way of its tip."""
    far = np.flatnonzero(np.abs(Z - 2.0) > 1.0)
    ring = np.setdiff1d(around(POINT, 0.5 * RADIUS), POINT)
    move = shift(0.5)

    def moved(use_exact):
        session = run(Session.bind(arap_native, MESH, np.eye(3), SETTINGS))
        run(session.set_handles([hold(far, use_exact=True), hold(POINT, use_exact=use_exact)]))
        return (pulled(session, move) - TUBE.positions)[:, 0]

    spike, hill = moved(use_exact=True), moved(use_exact=False)
    assert spike[POINT[0]] == pytest.approx(0.5, abs=1e-6)
    assert spike[ring].min() < 0.8 * spike[POINT[0]]
    assert hill[ring].min() > 0.9 * hill[POINT[0]]


def test_what_stays_exact():
    region = around(POINT, 1.5 * RADIUS)
    for handles, settings in (
        ((hold(region),), SETTINGS),
        ((hold(POINT, 0.9),), SETTINGS),
        ((hold(POINT, use_exact=True),), SETTINGS),
        ((hold(POINT),), dataclasses.replace(SETTINGS, energy="spokes_and_rims")),
        ((hold(POINT),), dataclasses.replace(SETTINGS, energy="spokes")),
        ((hold(POINT),), dataclasses.replace(SETTINGS, rigidity_radius=0.005)),  # below the edges: nothing to average
        ((hold([]),), SETTINGS),
    ):
        assert dict(new_session(*handles, settings=settings).patches) == {}
    region_session = new_session(hold(region))
    move = shift(0.2)
    np.testing.assert_allclose(pulled(region_session, move)[region], TUBE.positions[region] + move[:3, 3], atol=1e-6)


def test_a_group_smaller_than_the_radius_is_a_point():
    group = around(POINT, 0.9 * RADIUS)
    assert len(group) > 10
    patch = new_session(hold(group)).patches[1][0]
    assert set(group) < set(patch.vertices.tolist())


def test_small_pieces_of_a_handle_are_points_of_their_own():
    opposite, above = POINT + 24, POINT + 20 * 48
    session = new_session(hold(np.sort(np.concatenate([POINT, opposite, above, above + 1]))))
    patches = session.patches[1]
    assert sorted(patch.sources.tolist() for patch in patches) == [
        POINT.tolist(), opposite.tolist(), [*above.tolist(), *(above + 1).tolist()],
    ]  # fmt: skip
    alone = new_session(hold(POINT)).patches[1][0]
    np.testing.assert_array_equal(next(p for p in patches if POINT[0] in p.sources).vertices, alone.vertices)
    move = motion(rotation_z(0.2), (0.1, 0.0, 0.1))
    positions = pulled(session, move)
    for patch in patches:
        held = patch.weights @ positions[patch.vertices]
        np.testing.assert_allclose(held, move[:3, :3] @ patch.centre + move[:3, 3], atol=1e-5)


def test_pieces_beside_what_is_held_are_held_exactly():
    region, spot = around(POINT, 2.0 * RADIUS), POINT + 24
    patches = new_session(hold(np.union1d(region, spot))).patches[1]
    assert [patch.sources.tolist() for patch in patches] == [spot.tolist()]
    every_other = region[region % 2 == 0]
    assert dict(new_session(hold(every_other)).patches) == {}
    assert dict(new_session(hold(np.union1d(POINT, spot)), hold(POINT + 1), hold(spot + 1)).patches).get(1) is None


def test_a_patch_that_keeps_its_reach_leaves_out_what_others_hold():
    kept = dataclasses.replace(hold(POINT), reach=PATCH_REACH)
    beside = hold(POINT + 1, use_exact=True)
    alone = new_session(kept).patches[1][0]
    patch = new_session(kept, beside).patches[1][0]
    is_left = alone.vertices != POINT[0] + 1
    np.testing.assert_array_equal(patch.vertices, alone.vertices[is_left])
    np.testing.assert_allclose(patch.weights, alone.weights[is_left] / alone.weights[is_left].sum())
    covered = hold(alone.vertices, use_exact=True)
    assert dict(new_session(kept, covered).patches) == {}


def test_vertices_of_two_handles_are_held_exactly():
    session = new_session(hold(POINT), hold([POINT[0], POINT[0] + 1]))
    assert dict(session.patches) == {}


def test_patches_end_before_another_handle_or_a_pin():
    near = POINT + 3
    session = new_session(hold(POINT), hold(near))
    first, second = session.patches[1][0], session.patches[2][0]
    assert near[0] not in first.vertices
    assert POINT[0] not in second.vertices
    matrices = np.array([NO_MOTION, shift(0.1), shift(-0.1)])
    session.update(matrices, initial_guess="rest", to_convergence=True)
    for patch, x in ((first, 0.1), (second, -0.1)):
        held = patch.weights @ session.positions.astype(float)[patch.vertices]
        np.testing.assert_allclose(held, patch.centre + np.array([x, 0.0, 0.0]), atol=1e-5)
    pinned = POINT + 2 * 48
    beside_pin = run(Session.bind(arap_native, MESH, np.eye(3), SETTINGS))
    run(beside_pin.set_handles([hold(pinned, use_exact=True), hold(POINT)]))
    assert pinned[0] not in beside_pin.patches[1][0].vertices


def test_points_alone_take_the_whole_mesh_along():
    session = run(Session.bind(arap_native, MESH, np.eye(3), SETTINGS))
    run(session.set_handles([hold(POINT)]))
    move = shift(0.5, -1.0, 2.0)
    session.update(move[None], initial_guess="rest", to_convergence=True)
    np.testing.assert_allclose(session.positions, TUBE.positions + move[:3, 3], atol=1e-5)


def test_loose_vertices_are_held_exactly():
    mesh = dataclasses.replace(MESH, rest_positions=np.concatenate([TUBE.positions, [[2.0, 2.0, 2.0]]]))
    loose = len(TUBE.positions)
    session = new_session(hold([loose]), mesh=mesh)
    assert dict(session.patches) == {}
    np.testing.assert_allclose(pulled(session, shift(0.5))[loose], [2.5, 2.0, 2.0], atol=1e-6)


def test_loose_vertices_far_away_change_no_patch():
    mesh = dataclasses.replace(MESH, rest_positions=np.concatenate([TUBE.positions, [[20.0, 20.0, 20.0]]]))
    patch, expected = (new_session(hold(POINT), mesh=mesh).patches[1][0] for mesh in (mesh, MESH))
    np.testing.assert_array_equal(patch.vertices, expected.vertices)
    np.testing.assert_allclose(patch.weights, expected.weights, rtol=1e-4)  # of distances in single precision


def test_the_size_of_a_mesh_is_that_of_its_faces():
    points = np.array([[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0], [9.0, 9.0, 9.0]])
    assert surface_diagonal(points, np.array([0, 1, 2], dtype=np.int32)) == pytest.approx(5.0)
    assert surface_diagonal(points, np.empty(0, dtype=np.int32)) == 0.0


def test_a_point_on_a_rigid_piece_takes_it_along():
    rigid = around(POINT, 2.0 * RADIUS)
    regions = np.full(len(TUBE.positions), -1, np.int32)
    regions[rigid] = 0
    session = run(Session.bind(arap_native, MESH, np.eye(3), SETTINGS, rigid_regions=regions))
    run(session.set_handles([hold(BOTTOM, use_exact=True), hold(POINT)]))
    patch, move = session.patches[1][0], shift(0.3)
    positions = pulled(session, move)
    np.testing.assert_allclose(patch.weights @ positions[patch.vertices], patch.centre + move[:3, 3], atol=1e-5)
    fit = best_rigid_fit(TUBE.positions[rigid], positions[rigid], np.eye(3))
    np.testing.assert_allclose(TUBE.positions[rigid] @ fit[:3, :3].T + fit[:3, 3], positions[rigid], atol=1e-5)


def test_exact_is_part_of_the_constraints():
    session = new_session(hold(POINT))
    before = session.n_factorizations
    run(session.set_handles([hold(BOTTOM, use_exact=True), hold(POINT)]))
    assert session.n_factorizations == before
    run(session.set_handles([hold(BOTTOM, use_exact=True), hold(POINT, use_exact=True)]))
    assert session.n_factorizations == before + 1
    assert dict(session.patches) == {}


def test_rigidity_is_fixed_at_bind_for_the_energy_it_belongs_to():
    of_nodes = [dataclasses.replace(SETTINGS, rigidity_radius=radius).of_bind for radius in (0.02, 0.03)]
    of_classic = [dataclasses.replace(SETTINGS, energy="spokes", rigidity_radius=r).of_bind for r in (0.02, 0.03)]
    assert of_nodes[0] != of_nodes[1]
    assert of_classic[0] == of_classic[1]


def opened(mesh):
    """The same mesh with a seam: the faces on one side of y = 0 have vertices of their own."""
    n = len(mesh.rest_positions)
    starts = np.cumsum(mesh.face_sizes) - mesh.face_sizes
    below = np.add.reduceat(mesh.rest_positions[mesh.corner_vertices, 1], starts) < 0.0
    corners = mesh.corner_vertices + n * np.repeat(below, mesh.face_sizes).astype(np.int32)
    used, corners = np.unique(corners, return_inverse=True)
    return SessionMesh(mesh.rest_positions[used % n], corners.astype(np.int32), mesh.face_sizes)


@pytest.mark.parametrize("stretch", [np.eye(3), STRETCH], ids=["unscaled", "scaled"])
@pytest.mark.parametrize("weights", ["cotangent", "uniform"])
@pytest.mark.parametrize("join_seams", [False, True], ids=["open", "joined"])
def test_the_faces_around_a_handle_are_enough_to_find_its_patch(stretch, weights, join_seams):
    mesh = opened(MESH)
    rest = mesh.rest_positions
    group = np.flatnonzero(np.linalg.norm(rest - TUBE.positions[POINT], axis=1) < 0.5 * RADIUS).astype(np.int32)
    settings = dataclasses.replace(SETTINGS, weights=weights, join_seams=join_seams)
    session = run(Session.bind(arap_native, mesh, stretch, settings))
    run(session.set_handles([hold(group)]))
    whole = session.patches[0][0]
    seen = rest @ stretch.T
    reach = PATCH_REACH * settings.rigidity_radius * float(np.linalg.norm(np.ptp(seen, axis=0)))
    part = neighbourhood(seen, mesh.corner_vertices, mesh.face_sizes, group, reach)
    assert len(part.vertices) < len(rest) // 4
    local = local_patch(arap_native, rest, part, group, reach, stretch, settings)
    order = np.argsort(local.vertices), np.argsort(whole.vertices)
    assert np.array_equal(local.vertices[order[0]], whole.vertices[order[1]])
    np.testing.assert_allclose(local.weights[order[0]], whole.weights[order[1]], atol=1e-6)
    np.testing.assert_allclose(local.centre, whole.centre, atol=1e-6)


def test_targets_and_rotations_of_patches_come_last():
    rest = np.random.default_rng(5).normal(size=(9, 3))
    centre = rest[[4, 5]].mean(axis=0)
    patch = Patch(np.array([4, 5], np.int32), np.array([0.5, 0.5]), centre, np.array([4], np.int32))
    specs = [hold([4]), hold([0, 1]), hold([1, 2])]
    handle_map = HandleMap(specs, rest, STRETCH, {0: [patch]})
    assert handle_map.vertices.tolist() == [0, 2, 1]
    assert [part.tolist() for part in handle_map.patches] == [[0, 2], [4, 5], [0.5, 0.5]]
    turn = motion(np.linalg.inv(STRETCH) @ rotation_z(0.5) @ STRETCH, (1.0, 2.0, 3.0))
    matrices = np.array([turn, NO_MOTION, NO_MOTION])
    targets = handle_map.targets(matrices)
    np.testing.assert_allclose(targets[:3], rest[[0, 2, 1]] @ STRETCH.T, atol=1e-14)
    np.testing.assert_allclose(targets[3], STRETCH @ (turn[:3, :3] @ centre + turn[:3, 3]), atol=1e-14)
    rotations = handle_map.rotations(matrices)
    assert rotations.shape == (4, 3, 3)
    np.testing.assert_allclose(rotations[3], rotation_z(0.5), atol=1e-12)


def test_a_weighted_fit_takes_the_average_to_the_average():
    rng = np.random.default_rng(2)
    rest, shown, weights = rng.normal(size=(9, 3)), rng.normal(size=(9, 3)), rng.uniform(size=9)
    for stretch in (np.eye(3), STRETCH):
        fit = best_rigid_fit(rest, shown, stretch, weights)
        average = np.average(rest, axis=0, weights=weights)
        expected = np.average(shown, axis=0, weights=weights)
        np.testing.assert_allclose(fit[:3, :3] @ average + fit[:3, 3], expected, atol=1e-9)


def test_another_base_moves_the_target_without_a_factorization():
    session = new_session(hold(TOP, use_exact=True), hold(POINT))
    n_factorizations = session.n_factorizations
    base = np.add(TUBE.positions, (0.0, 0.3, 0.0))
    based = dataclasses.replace(hold(POINT), base=base)
    run(session.set_handles([hold(BOTTOM, use_exact=True), hold(TOP, use_exact=True), based]))
    assert session.n_factorizations == n_factorizations
    session.update(np.array([NO_MOTION] * 3), to_convergence=True)
    patch = session.patches[2][0]
    np.testing.assert_allclose(patch.centre, patch.weights @ base[patch.vertices], atol=1e-12)
    np.testing.assert_allclose(patch.weights @ session.positions[patch.vertices], patch.centre, atol=1e-5)
    run(session.set_handles([hold(BOTTOM, use_exact=True), hold(TOP, use_exact=True), hold(POINT)]))
    session.update(np.array([NO_MOTION] * 3), to_convergence=True)
    np.testing.assert_allclose(session.positions, TUBE.positions, atol=1e-3)
