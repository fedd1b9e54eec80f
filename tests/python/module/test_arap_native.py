# SPDX-License-Identifier: GPL-3.0-or-later
"""arap_native from the outside: what its calls do and give back. The mathematics is tested in tests/native."""

import inspect

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


# ------------------------------------------------------------------------------------------------------- solving


def test_given_rotations_are_those_of_the_rows():
    mesh = tube()
    turn = rotation_z(0.8) @ rotation_z(0.3)[:, [2, 0, 1]]
    shift = np.array([3.0, -1.0, 2.0])
    vertices = ends(mesh)
    moved = mesh.positions @ turn.T + shift

    def error(rotation) -> float:
        result = held_at_ends(mesh).solve(
            moved[vertices],
            arap_native.SolveOptions(initial_guess="handle_rotations", max_iterations=1),
            rotations=np.tile(rotation, (len(vertices), 1, 1)),
        )
        return np.abs(result.positions - moved).max() / mesh.diagonal

    assert error(turn) < 1e-6
    assert error(turn.T) > 1e-2, "by rows, not by columns"


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


def test_energies_of_a_result_and_of_positions():
    mesh = tube()
    solver = held_at_ends(mesh)
    result = solver.solve(twisted_ends(mesh), arap_native.SolveOptions(accuracy=1e-8))
    assert 0 < result.energy_after < result.energy_before
    assert solver.energy(result.positions) == pytest.approx(result.energy_after, rel=1e-9)
    gradient = solver.energy_gradient(result.positions)
    assert (gradient.dtype, gradient.shape) == (np.float64, mesh.positions.shape)
    step = 1e-5 * mesh.diagonal * np.random.default_rng(5).uniform(-1, 1, gradient.shape)
    change = solver.energy(result.positions + step) - solver.energy(result.positions - step)
    assert change == pytest.approx(2 * np.sum(gradient * step), rel=1e-4)


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


def test_positions_are_read_set_and_reset():
    mesh = tube()
    solver = held_at_ends(mesh)
    result = solver.solve(twisted_ends(mesh))
    assert np.array_equal(solver.positions, result.positions)
    solver.reset()
    assert np.allclose(solver.positions, mesh.positions, rtol=0, atol=1e-12)
    solver.set_positions(result.positions)
    assert np.allclose(solver.positions, result.positions, rtol=0, atol=1e-12)


def test_without_strengths_all_vertices_are_hard():
    mesh = tube()
    solver = bound(mesh)
    solver.set_constraints(ends(mesh))
    expected = held_at_ends(mesh).solve(twisted_ends(mesh)).positions
    assert np.array_equal(solver.solve(twisted_ends(mesh)).positions, expected)


def test_loose_vertices_and_parts_without_constraints_are_reported():
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
    assert (result.parts_at_rest.tolist(), result.loose_vertices.tolist()) == ([1], [2 * n])


def test_a_rigid_region_keeps_its_shape():
    mesh = tube()
    middle = np.abs(mesh.positions[:, 2] - 2.0) < 0.8
    solver = held_at_ends(mesh, rigid_regions=np.where(middle, 0, -1).astype(np.int32))
    targets = twisted_ends(mesh)
    targets[8:] += [1.5, 0.0, -0.5]
    posed = solver.solve(targets).positions[middle]
    rest = mesh.positions[middle]
    lengths, rest_lengths = (np.linalg.norm(p[:, None] - p[None], axis=-1) for p in (posed, rest))
    assert np.abs(lengths - rest_lengths).max() < 1e-6 * mesh.diagonal


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
    options = arap_native.Options(energy="spokes", rigidity_radius=0.5, weights="uniform", threads=2, join_seams=True)
    assert (options.energy, options.weights) == ("spokes", "uniform")
    assert options.rigidity_radius == 0.5
    assert (options.threads, options.join_seams) == (2, True)
    assert repr(options) == (
        "Options(energy='spokes', rigidity_radius=0.5, weights='uniform', threads=2, join_seams=True)"
    )

    assert repr(arap_native.Options()) == (
        "Options(energy='rotation_nodes', rigidity_radius=0.02, weights='cotangent', threads=0, join_seams=False)"
    )

    options = arap_native.SolveOptions(initial_guess="rest", max_iterations=3, time_limit_s=0.5)
    assert repr(options) == (
        "SolveOptions(initial_guess='rest', acceleration='conjugate_gradients', max_iterations=3, "
        "accuracy=1e-06, time_limit_s=0.5)"
    )
    defaults = arap_native.SolveOptions()
    assert (defaults.initial_guess, defaults.time_limit_s) == ("previous", float("inf"))


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


def test_repr_says_what_it_is():
    mesh = tube()
    solver = held_at_ends(mesh, options=arap_native.Options(threads=1))
    assert repr(bound(mesh, options=arap_native.Options(threads=1))) == (
        "<SurfaceArap: 96 vertices, 1 part, no constraints, 1 thread>"
    )
    assert repr(solver) == "<SurfaceArap: 96 vertices, 1 part, 0 at rest, 1 thread>"
    text = repr(solver.solve(twisted_ends(mesh), arap_native.SolveOptions(max_iterations=2)))
    assert text.startswith("<SolveResult: max_iterations after 2 iterations, energy ")
    assert text.endswith(", 1 part, 0 at rest, 0 loose vertices>")


def torn(mesh: Mesh) -> Mesh:
    """Each ring of quads by itself, and the ends: open seams all around, as a texture's."""
    n_rings = len(mesh.face_sizes) // 8
    faces = np.split(mesh.corner_vertices, np.cumsum(mesh.face_sizes)[:-1])
    groups = [np.concatenate(faces[8 * k : 8 * k + 8]) for k in range(n_rings)] + faces[8 * n_rings :]
    positions, corners = [], []
    for group in groups:
        used, own = np.unique(group, return_inverse=True)
        corners.append(own.ravel() + sum(map(len, positions)))
        positions.append(mesh.positions[used])
    return Mesh(np.concatenate(positions), np.concatenate(corners).astype(np.int32), mesh.face_sizes)


@pytest.mark.parametrize(
    "model", [kind for kind in arap_native.Model.__subclasses__() if "face_sizes" in inspect.signature(kind).parameters]
)
def test_an_open_seam_is_told(model):
    mesh = torn(tube())
    keywords = {"cage": arap_native.make_cage(*mesh, cells=4)} if model is arap_native.CageArap else {}
    solver = model(*mesh, **keywords)
    assert (solver.n_parts, solver.n_parts_joined) == (13, 1)
    assert ", 13 parts (1 with seams joined), no constraints, " in repr(solver)
    vertices = np.flatnonzero(mesh.positions[:, 2] > 3.5)
    solver.set_constraints(vertices)
    result = solver.solve(mesh.positions[vertices] + [0.0, 0.2, 0.0])
    assert (result.n_parts, result.n_parts_joined) == (13, 1)
    n_at_rest = len(result.parts_at_rest)
    assert n_at_rest >= 10 or model is arap_native.CageArap, "a cage carries all that is in it"
    assert f", 13 parts (1 with seams joined), {n_at_rest} at rest, " in repr(result)
    assert f", 13 parts (1 with seams joined), {n_at_rest} at rest, " in repr(solver)


def test_parts_of_a_mesh_with_joined_seams_are_those_of_the_model():
    solver = bound(torn(tube()), options=arap_native.Options(join_seams=True))
    assert (solver.n_parts, solver.n_parts_joined) == (1, 1)
    assert ", 1 part, no constraints, " in repr(solver)


def test_a_void_counts_with_its_shell_in_a_lattice():
    outer = tube()
    faces = np.split(outer.corner_vertices, np.cumsum(outer.face_sizes)[:-1])
    middle = outer.positions.mean(axis=0)
    mesh = Mesh(
        np.concatenate((outer.positions, middle + 0.6 * (outer.positions - middle))),
        np.concatenate([outer.corner_vertices] + [face[::-1] + len(outer.positions) for face in faces]),
        np.concatenate((outer.face_sizes, outer.face_sizes)),
    )
    solver = arap_native.LatticeArap(*mesh)
    assert (solver.n_parts, solver.n_parts_joined) == (1, 1)
    assert ", 1 part, no constraints, " in repr(solver)
    apart = arap_native.LatticeArap(*torn(mesh))
    assert apart.n_parts > 1
    assert apart.n_parts_joined == 1


# ---------------------------------------------------------------------------------------------------- same places


def test_places_are_the_same_if_single_precision_has_torn_them():
    square = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    two = np.concatenate([square, square + np.array([1.0000002, 0, 0])])
    corners, sizes = np.arange(8, dtype=np.int32), np.full(2, 4, np.int32)
    places = arap_native.same_places(two, corners, sizes)
    assert places.dtype == np.int32
    assert places.tolist() == [0, 1, 2, 3, 1, 5, 6, 2]
    two[4] += 1e-4
    assert arap_native.same_places(two, corners, sizes).tolist() == [0, 1, 2, 3, 4, 5, 6, 2]
    with pytest.raises(ValueError, match="face 0 names vertex 9"):
        arap_native.same_places(two, np.array([[0, 1, 9]], np.int32))


def test_an_energy_beyond_all_numbers_is_refused():
    mesh = tube()
    solver = arap_native.SurfaceArap(mesh.positions * 1e-80, mesh.corner_vertices, mesh.face_sizes)
    with pytest.raises(RuntimeError, match="too large for a number"):
        solver.energy(mesh.positions * [1e90, 2e90, 3e90])
