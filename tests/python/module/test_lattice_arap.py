# SPDX-License-Identifier: GPL-3.0-or-later
"""LatticeArap from the outside: what it has in common with SurfaceArap, and what only it has."""

import arap_native
import numpy as np
import pytest
from sample_meshes import Mesh, ends, sheet, tube, twisted_ends


def held_at_ends(mesh: Mesh, **keywords) -> arap_native.LatticeArap:
    model = arap_native.LatticeArap(*mesh, **keywords)
    model.set_constraints(ends(mesh))
    return model


def girth(positions: np.ndarray, segments: int) -> np.ndarray:
    """Mean distance of each ring's vertices from its middle."""
    rings = positions.reshape(-1, segments, 3)
    return np.linalg.norm(rings - rings.mean(axis=1, keepdims=True), axis=2).mean(axis=1)


def test_a_twisted_tube_keeps_its_girth_better_than_its_surface_alone():
    mesh = tube(60, 24)
    targets = twisted_ends(mesh, np.pi)
    surface = arap_native.SurfaceArap(*mesh)
    surface.set_constraints(ends(mesh))
    thinnest = {
        type(model).__name__: girth(model.solve(targets).positions, 24).min() / 0.5
        for model in (surface, held_at_ends(mesh))
    }
    assert thinnest["LatticeArap"] > thinnest["SurfaceArap"]
    assert thinnest["LatticeArap"] > 0.75


def test_hard_vertices_are_at_their_targets():
    mesh = tube(60, 24)
    targets = twisted_ends(mesh)
    positions = held_at_ends(mesh).solve(targets).positions
    assert np.abs(positions[ends(mesh)] - targets).max() < 1e-6 * mesh.diagonal


def test_jobs_do_what_the_calls_do():
    mesh = tube()
    called = held_at_ends(mesh).solve(twisted_ends(mesh))
    model = arap_native.LatticeArap.begin_bind(*mesh).result()
    assert type(model) is arap_native.LatticeArap
    assert model.begin_set_constraints(ends(mesh)).result() is None
    result = model.begin_solve(twisted_ends(mesh)).result()
    assert np.array_equal(result.positions, called.positions)
    assert np.array_equal(model.positions, called.positions)


def test_it_is_a_model_as_the_surface_is():
    model = held_at_ends(tube())
    assert isinstance(model, arap_native.Model)
    assert isinstance(arap_native.SurfaceArap(*tube()), arap_native.Model)
    assert (model.n_vertices, model.n_parts, model.n_factorizations) == (96, 1, 1)
    with pytest.raises(TypeError):
        arap_native.Model()


def test_the_cubes_are_as_large_as_is_asked():
    mesh = tube(60, 24)
    models = [
        arap_native.LatticeArap(*mesh, options=arap_native.LatticeOptions(cube_size=cube_size))
        for cube_size in (0.1, 0.05)
    ]
    assert [model.cube_size / mesh.diagonal for model in models] == pytest.approx([0.1, 0.05], rel=1e-3)
    assert models[0].n_control_points < models[1].n_control_points


def test_a_rigid_region_keeps_its_shape():
    mesh = tube()
    middle = np.abs(mesh.positions[:, 2] - 2.0) < 0.8
    targets = twisted_ends(mesh)
    targets[8:] += [1.5, 0.0, -0.5]
    model = held_at_ends(mesh, rigid_regions=np.where(middle, 0, -1).astype(np.int32))
    posed, rest = model.solve(targets).positions[middle], mesh.positions[middle]
    lengths, rest_lengths = (np.linalg.norm(p[:, None] - p[None], axis=-1) for p in (posed, rest))
    assert np.abs(lengths - rest_lengths).max() < 1e-6 * mesh.diagonal


def test_options_are_named_values():
    options = arap_native.LatticeOptions()
    assert repr(options) == "LatticeOptions(cube_size=0.0, keep_volume=0.0, threads=0, join_seams=False)"
    options = arap_native.LatticeOptions(cube_size=0.5, keep_volume=0.25, threads=2, join_seams=True)
    assert (options.cube_size, options.keep_volume, options.threads, options.join_seams) == (0.5, 0.25, 2, True)
    with pytest.raises(ValueError, match=r"^cube_size = 2, must be "):
        options.cube_size = 2
    assert options.cube_size == 0.5


def test_what_has_no_inside_is_refused_in_words():
    mesh = sheet(3)
    no_faces = np.zeros(0, np.int32)
    with pytest.raises(ValueError, match="no faces"):
        arap_native.LatticeArap(mesh.positions, no_faces, no_faces)
    with pytest.raises(ValueError, match="size"):
        arap_native.LatticeArap(np.zeros_like(mesh.positions), *mesh[1:])


def test_its_messages_name_it():
    model = held_at_ends(tube(60, 24))
    job = model.begin_solve(twisted_ends(tube(60, 24)), arap_native.SolveOptions(accuracy=0, max_iterations=10**6))
    with pytest.raises(RuntimeError, match=r"^this LatticeArap is at work in a job"):
        model.reset()
    job.cancel()
    assert job.result().stop_reason == "cancelled"


def test_bones_move_what_is_around_them():
    mesh = tube(60, 24)
    model = arap_native.LatticeArap(*mesh)
    bones = np.array([[[0.0, 0.0, 0.2], [0.0, 0.0, 2.0]], [[0.0, 0.0, 2.0], [0.0, 0.0, 3.8]]])
    beside = np.array([[[2.0, 0.0, 0.0], [2.0, 0.0, 1.0]]])
    assert model.segments_outside(np.concatenate([beside, bones])).tolist() == [0]
    none = np.empty(0, np.int32)
    model.set_constraints(none, segments=bones)
    lengths = np.linalg.norm(bones[:, 1] - bones[:, 0], axis=1)[:, None, None]
    targets = bones[:, :1] + lengths * np.concatenate([np.zeros((1, 3)), np.eye(3)])
    targets[1] += [0.0, 0.4, 0.0]
    posed = model.solve(targets.reshape(-1, 3)).positions
    top, bottom = mesh.positions[:, 2] > 3.5, mesh.positions[:, 2] < 0.5
    np.testing.assert_allclose(posed[top], mesh.positions[top] + [0.0, 0.4, 0.0], atol=0.05)
    np.testing.assert_allclose(posed[bottom], mesh.positions[bottom], atol=0.05)
    assert model.begin_set_constraints(none, None, None, bones).result() is None


def test_bones_have_two_ends_and_need_an_inside():
    mesh = tube()
    none = np.empty(0, np.int32)
    with pytest.raises(ValueError, match=r"^segments has shape \(2, 3\), expected \(s, 2, 3\): head and tail of each"):
        arap_native.LatticeArap(*mesh).set_constraints(none, segments=np.zeros((2, 3)))
    with pytest.raises(ValueError, match=r"^segments need a model with an inside, .*use LatticeArap$"):
        arap_native.SurfaceArap(*mesh).set_constraints(none, segments=np.eye(2, 3)[None])
