# SPDX-License-Identifier: GPL-3.0-or-later
"""arap_native from the outside: what its calls do and give back. The mathematics is tested in tests/native."""

import copy

import arap_native
import numpy as np
import pytest
from sample_meshes import Mesh, ends, rotation_z, tube, twisted_ends


def bound(mesh: Mesh, **keywords) -> arap_native.SurfaceArap:
    return arap_native.SurfaceArap(*mesh, **keywords)


def held_at_ends(mesh: Mesh, **keywords) -> arap_native.SurfaceArap:
    solver = bound(mesh, **keywords)
    vertices = ends(mesh)
    solver.set_constraints(vertices, np.ones(len(vertices)))
    return solver


# ---------------------------------------------------------------------------------------------------- mathematics


@pytest.mark.parametrize("energy", ["rotation_nodes", "spokes_and_rims", "spokes"])
@pytest.mark.parametrize("weights", ["cotangent", "uniform"])
@pytest.mark.parametrize("guess", ["previous", "rest", "naive_laplacian", "handle_rotations"])
def test_rest_in_rest_out(energy, weights, guess):
    mesh = tube()
    solver = held_at_ends(mesh, options=arap_native.Options(energy=energy, weights=weights))
    result = solver.solve(mesh.positions[ends(mesh)], arap_native.SolveOptions(initial_guess=guess))
    assert np.abs(result.positions - mesh.positions).max() < 1e-6 * mesh.diagonal
    assert result.stop_reason == "converged"


@pytest.mark.parametrize("give_rotations", [True, False])
def test_rigid_motion_of_the_handles_moves_the_mesh_rigidly(give_rotations):
    mesh = tube()
    turn = rotation_z(0.8) @ rotation_z(0.3)[:, [2, 0, 1]]
    shift = np.array([3.0, -1.0, 2.0])
    vertices = ends(mesh)
    rotations = np.tile(turn, (len(vertices), 1, 1)) if give_rotations else None
    result = held_at_ends(mesh).solve(
        mesh.positions[vertices] @ turn.T + shift,
        arap_native.SolveOptions(initial_guess="handle_rotations"),
        rotations=rotations,
    )
    assert np.abs(result.positions - (mesh.positions @ turn.T + shift)).max() < 1e-6 * mesh.diagonal


def test_positions_go_into_an_array_that_is_given():
    mesh = tube()
    expected = held_at_ends(mesh).solve(twisted_ends(mesh)).positions
    out = np.full(mesh.positions.shape, np.nan, dtype=np.float32)
    result = held_at_ends(mesh).solve(twisted_ends(mesh), out=out)
    assert result.positions is out
    assert np.array_equal(out, expected.astype(np.float32))


def test_a_cancelled_solve_gives_the_former_positions_to_an_array_too():
    mesh = tube()
    solver = held_at_ends(mesh)
    out = np.full(mesh.positions.shape, np.nan, dtype=np.float32)
    result = solver.solve(twisted_ends(mesh), progress=lambda _: False, out=out)
    assert result.stop_reason == "cancelled"
    assert np.array_equal(out, mesh.positions.astype(np.float32))


def test_the_time_limit_is_that_of_the_whole_solve():
    mesh = tube()
    limits = arap_native.SolveOptions(time_limit_s=1e-9, initial_guess="handle_rotations")
    result = held_at_ends(mesh).solve(twisted_ends(mesh), limits)
    assert (result.iterations, result.stop_reason) == (1, "time_limit")


def test_hard_constraints_are_met_exactly_and_energy_is_that_of_the_result():
    mesh = tube()
    solver = held_at_ends(mesh)
    targets = twisted_ends(mesh)
    in_double = arap_native.SolveOptions(accuracy=1e-8)
    result = solver.solve(targets, in_double)
    assert np.abs(result.positions[ends(mesh)] - targets).max() < 1e-12 * mesh.diagonal
    assert 0 < result.energy_after < result.energy_before
    assert solver.energy(result.positions) == pytest.approx(result.energy_after, rel=1e-9)
    assert solver.energy(mesh.positions) == pytest.approx(0, abs=1e-12)


def test_energy_gradient_is_that_of_finite_differences():
    mesh = tube()
    solver = bound(mesh)
    rng = np.random.default_rng(5)
    positions = mesh.positions + 0.02 * mesh.diagonal * rng.uniform(-1, 1, mesh.positions.shape)
    gradient = solver.energy_gradient(positions)
    assert (gradient.dtype, gradient.shape) == (np.float64, positions.shape)
    for _ in range(5):
        step = 1e-5 * mesh.diagonal * rng.uniform(-1, 1, positions.shape)
        change = solver.energy(positions + step) - solver.energy(positions - step)
        assert change == pytest.approx(2 * np.sum(gradient * step), rel=1e-5)


def test_soft_constraint_gives_way_and_more_strength_gives_way_less():
    mesh = tube()
    vertices, targets = ends(mesh), twisted_ends(mesh)
    distances = []
    for strength in (0.1, 0.5, 0.9):
        solver = bound(mesh)
        solver.set_constraints(vertices, np.full(len(vertices), strength))
        result = solver.solve(targets, arap_native.SolveOptions(max_iterations=500))
        distances.append(np.abs(result.positions[vertices] - targets).max())
    assert distances[0] > distances[1] > distances[2] > 0


def test_patch_holds_its_weighted_average():
    mesh = tube()
    solver = bound(mesh)
    lower, upper = np.split(ends(mesh), 2)
    weights = np.linspace(1.0, 2.0, len(upper))
    solver.set_constraints(lower, np.ones(len(lower)), (np.array([0, len(upper)], np.int32), upper, weights))
    targets = np.vstack([mesh.positions[lower], [[0.5, 0.0, 4.2]]])
    result = solver.solve(targets)
    assert np.average(result.positions[upper], axis=0, weights=weights) == pytest.approx(targets[-1], abs=1e-9)


@pytest.mark.parametrize("linear_solver", ["block_ldlt", "simplicial_ldlt", "sparse_lu", "sparse_qr", "bicgstab"])
def test_every_linear_solver_ends_at_the_same_shape(linear_solver):
    mesh = tube()
    options = arap_native.Options(linear_solver=linear_solver)
    assert options.linear_solver == linear_solver
    to_the_end = arap_native.SolveOptions(max_iterations=10**4, accuracy=1e-9)
    result = held_at_ends(mesh, options=options).solve(twisted_ends(mesh), to_the_end)
    expected = held_at_ends(mesh).solve(twisted_ends(mesh), to_the_end)
    assert result.stop_reason == "converged"
    assert np.abs(result.positions - expected.positions).max() < 1e-6 * mesh.diagonal


# ------------------------------------------------------------------------------------------------------- solving


def test_triangles_may_come_as_rows():
    positions = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0]], np.float64)
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    results = []
    for faces in [(triangles,), (triangles.ravel(), np.array([3, 3], np.int32))]:
        solver = arap_native.SurfaceArap(positions, *faces)
        solver.set_constraints(np.array([0, 1], np.int32), np.ones(2))
        results.append(solver.solve(np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])).positions)
    assert np.array_equal(*results)


def test_stop_reasons():
    mesh = tube()
    targets = twisted_ends(mesh)
    solver = held_at_ends(mesh)

    result = solver.solve(targets, arap_native.SolveOptions(max_iterations=2))
    assert (result.stop_reason, result.iterations) == ("max_iterations", 2)

    endless = arap_native.SolveOptions(max_iterations=10**6, accuracy=0, time_limit_s=1e-9)
    result = solver.solve(targets, endless)
    assert (result.stop_reason, result.iterations) == ("time_limit", 1)

    result = solver.solve(targets, arap_native.SolveOptions(max_iterations=10**4))
    assert result.stop_reason == "converged"
    assert result.step <= 1e-6


def test_previous_positions_are_where_the_next_solve_begins():
    mesh = tube()
    solver = held_at_ends(mesh)
    targets = twisted_ends(mesh)
    five_in_double = arap_native.SolveOptions(max_iterations=5, accuracy=1e-8)
    first = solver.solve(targets, five_in_double)
    second = solver.solve(targets, five_in_double)
    assert second.energy_before == pytest.approx(first.energy_after, rel=1e-9)
    assert np.array_equal(solver.positions, second.positions)

    solver.reset()
    assert np.allclose(solver.positions, mesh.positions, rtol=0, atol=1e-12)
    solver.set_positions(first.positions)
    assert np.allclose(solver.positions, first.positions, rtol=0, atol=1e-12)
    assert np.allclose(solver.solve(targets, five_in_double).positions, second.positions, rtol=0, atol=1e-6)


def test_only_a_new_set_of_constraints_factorizes():
    mesh = tube()
    solver = held_at_ends(mesh)
    once = solver.n_factorizations
    assert once > 0
    vertices = ends(mesh)
    solver.solve(twisted_ends(mesh))
    solver.solve(twisted_ends(mesh, angle_rad=-1.0))
    solver.set_constraints(vertices, np.ones(len(vertices)))
    assert solver.n_factorizations == once
    solver.set_constraints(vertices[1:], np.ones(len(vertices) - 1))
    assert solver.n_factorizations > once


def test_without_strengths_all_vertices_are_hard():
    mesh = tube()
    solver = bound(mesh)
    solver.set_constraints(ends(mesh))
    expected = held_at_ends(mesh).solve(twisted_ends(mesh)).positions
    assert np.array_equal(solver.solve(twisted_ends(mesh)).positions, expected)


def test_loose_vertices_and_parts_without_constraints_stay_and_are_reported():
    near = tube()
    n = len(near.positions)
    positions = np.vstack([near.positions, near.positions + np.array([5.0, 0.0, 0.0]), [[9.0, 9.0, 9.0]]])
    mesh = Mesh(
        positions,
        np.concatenate([near.corner_vertices, near.corner_vertices + np.int32(n)]),
        np.tile(near.face_sizes, 2),
    )
    solver = bound(mesh)
    assert (solver.n_vertices, solver.n_parts) == (2 * n + 1, 2)
    assert solver.part_of_vertex.tolist() == [0] * n + [1] * n + [-1]
    assert solver.loose_vertices.tolist() == [2 * n]

    vertices = ends(near)
    solver.set_constraints(vertices, np.ones(len(vertices)))
    result = solver.solve(twisted_ends(near))
    assert result.parts_at_rest.tolist() == [1]
    assert result.loose_vertices.tolist() == [2 * n]
    assert np.allclose(result.positions[n:], positions[n:], rtol=0, atol=1e-12)


def test_joined_seam_does_not_open():
    mesh = tube(rings=4)
    half = len(mesh.positions)
    doubled = Mesh(
        np.vstack([mesh.positions, mesh.positions + np.array([0.0, 0.0, 4.0])]),
        np.concatenate([mesh.corner_vertices, mesh.corner_vertices + np.int32(half)]),
        np.tile(mesh.face_sizes, 2),
    )
    solver = bound(doubled, options=arap_native.Options(join_seams=True))
    lower, upper = ends(mesh)[:8], ends(mesh)[8:] + np.int32(half)
    vertices = np.concatenate([lower, upper])
    solver.set_constraints(vertices, np.ones(16))
    targets = doubled.positions[vertices]
    targets[8:] += [1.0, 0.0, 0.0]
    posed = solver.solve(targets).positions
    assert np.abs(posed[ends(mesh)[8:]] - posed[lower + np.int32(half)]).max() < 1e-9


def test_rigid_region_keeps_its_shape_and_stiffness_bends_less():
    mesh = tube()
    targets = twisted_ends(mesh)
    targets[8:] += [1.5, 0.0, -0.5]
    middle = np.abs(mesh.positions[:, 2] - 2.0) < 0.8
    region = np.where(middle, 0, -1).astype(np.int32)
    rest = mesh.positions[middle]

    def off_rigid(**properties) -> float:
        posed = held_at_ends(mesh, **properties).solve(targets, arap_native.SolveOptions(max_iterations=500)).positions
        posed = posed[middle]
        u, _, vt = np.linalg.svd((rest - rest.mean(0)).T @ (posed - posed.mean(0)))
        u[:, -1] *= np.linalg.det(u @ vt)
        return float(np.abs((rest - rest.mean(0)) @ (u @ vt) - (posed - posed.mean(0))).max()) / mesh.diagonal

    plain = off_rigid()
    assert off_rigid(rigid_regions=region) < 1e-6 < plain
    assert off_rigid(stiffness=np.where(middle, 100.0, 1.0)) < 0.5 * plain


# -------------------------------------------------------------------------------------------------------- arrays


def test_read_only_arrays_are_accepted_and_inputs_stay_as_they_are():
    mesh = tube()
    vertices, strengths, targets = ends(mesh), np.ones(16), twisted_ends(mesh)
    arrays = [*mesh, vertices, strengths, targets]
    before = [array.copy() for array in arrays]
    for array in arrays:
        array.flags.writeable = False
    solver = bound(mesh)
    solver.set_constraints(vertices, strengths)
    solver.solve(targets)
    assert all(np.array_equal(array, copied) for array, copied in zip(arrays, before, strict=True))


def test_input_arrays_may_be_reused_after_the_call():
    mesh = tube()
    solver = held_at_ends(mesh)
    expected = solver.solve(twisted_ends(mesh)).positions

    positions, vertices, strengths = mesh.positions.copy(), ends(mesh), np.ones(16)
    solver = bound(mesh._replace(positions=positions))
    positions[:] = np.nan
    solver.set_constraints(vertices, strengths)
    vertices[:] = -1
    assert np.array_equal(solver.solve(twisted_ends(mesh)).positions, expected)


def test_results_are_handed_over_without_a_copy_and_outlive_the_solver():
    mesh = tube()
    solver = held_at_ends(mesh)
    result = solver.solve(twisted_ends(mesh))
    positions = result.positions
    assert positions is result.positions
    assert not positions.flags.owndata
    assert positions.flags.c_contiguous
    assert (positions.dtype, positions.shape) == (np.float64, mesh.positions.shape)
    assert all(array.dtype == np.int32 for array in (result.parts_at_rest, result.loose_vertices))
    kept = positions.copy()
    del solver, result
    assert np.array_equal(positions, kept)


def test_writing_to_what_a_solver_gave_does_not_reach_the_solver():
    mesh = tube()
    solver = held_at_ends(mesh)
    result = solver.solve(twisted_ends(mesh))
    kept = result.positions.copy()
    result.positions[:] = np.nan
    solver.positions[:] = np.nan
    solver.part_of_vertex[:] = 7
    assert np.array_equal(solver.positions, kept)
    assert set(solver.part_of_vertex.tolist()) == {0}


# ----------------------------------------------------------------------------------------------- options and repr


def test_options_are_named_values():
    options = arap_native.Options(
        energy="spokes", rigidity_radius=0.5, weights="uniform", linear_solver="sparse_lu", threads=2, join_seams=True
    )
    assert (options.energy, options.weights, options.linear_solver) == ("spokes", "uniform", "sparse_lu")
    assert options.rigidity_radius == 0.5
    assert (options.threads, options.join_seams) == (2, True)
    assert repr(options) == (
        "Options(energy='spokes', rigidity_radius=0.5, weights='uniform', linear_solver='sparse_lu', threads=2, "
        "join_seams=True)"
    )
    options.energy = "spokes_and_rims"
    assert options.energy == "spokes_and_rims"

    options = arap_native.SolveOptions(initial_guess="rest", max_iterations=3, time_limit_s=0.5)
    assert repr(options) == (
        "SolveOptions(initial_guess='rest', acceleration='conjugate_gradients', max_iterations=3, "
        "accuracy=1e-06, time_limit_s=0.5)"
    )
    assert arap_native.SolveOptions().time_limit_s == float("inf")


def test_a_patch_around_vertices_is_an_average_to_constrain():
    mesh = tube()
    solver = bound(mesh, options=arap_native.Options(rigidity_radius=0.1))
    around = np.array([mesh.positions.shape[0] // 2], np.int32)
    vertices, weights, rest = solver.patch_around(around)
    assert (vertices.dtype, weights.dtype, rest.shape) == (np.int32, np.float64, (3,))
    assert vertices[0] == around[0]
    assert weights.sum() == pytest.approx(1)
    assert np.abs(weights @ mesh.positions[vertices] - rest).max() < 1e-12 * mesh.diagonal
    fewer, _, _ = solver.patch_around(around, radius=0.05)
    assert set(fewer) < set(vertices)

    offsets = np.array([0, len(vertices)], np.int32)
    held = ends(mesh)
    solver.set_constraints(held, np.ones(len(held)), (offsets, vertices, weights))
    target = rest + np.array([0, 0, 0.05 * mesh.diagonal])
    result = solver.solve(np.vstack([mesh.positions[held], target]))
    assert np.abs(weights @ result.positions[vertices] - target).max() < 1e-6 * mesh.diagonal


def test_a_refused_value_leaves_the_options_as_they_were():
    options = arap_native.SolveOptions(max_iterations=3)
    with pytest.raises(ValueError, match="max_iterations = 0, must be >= 1"):
        options.max_iterations = 0
    assert options.max_iterations == 3


def test_options_are_read_at_the_call():
    mesh = tube()
    solver = held_at_ends(mesh)
    options = arap_native.SolveOptions(max_iterations=1)
    assert solver.solve(twisted_ends(mesh), options).iterations == 1
    options.max_iterations = 2
    assert solver.solve(twisted_ends(mesh), options).iterations == 2


def test_threads_are_as_asked_for():
    mesh = tube()
    assert bound(mesh, options=arap_native.Options(threads=1)).threads == 1
    assert bound(mesh).threads == 1, "a mesh this small does not pay a second thread"


def test_repr_says_what_it_is():
    mesh = tube()
    solver = held_at_ends(mesh, options=arap_native.Options(threads=1))
    assert repr(solver) == "<SurfaceArap: 96 vertices, 1 part, 1 thread>"
    text = repr(solver.solve(twisted_ends(mesh), arap_native.SolveOptions(max_iterations=2)))
    assert text.startswith("<SolveResult: max_iterations after 2 iterations, energy ")
    assert text.endswith(", 0 parts at rest, 0 loose vertices>")


def test_a_solver_cannot_be_copied():
    with pytest.raises(TypeError, match="cannot pickle"):
        copy.copy(bound(tube()))
