# SPDX-License-Identifier: GPL-3.0-or-later
"""PoissonEditing from the outside: what it does with turns, and what it has in common with the other models."""

import arap_native
import numpy as np
import pytest
from numpy.typing import NDArray
from sample_meshes import Mesh, ends, rotation_z, tube, twisted_ends

MESH = tube()
# The other way round would be several times as far.
CLOSE = 0.15


def held_at_ends(mesh: Mesh = MESH, **options) -> arap_native.PoissonEditing:
    model = arap_native.PoissonEditing(*mesh, options=arap_native.PoissonOptions(**options))
    model.set_constraints(ends(mesh))
    return model


def turns_of_ends(angle_rad: float, scale: float = 1.0, mesh: Mesh = MESH) -> NDArray[np.float64]:
    """The far end turns and grows."""
    far = mesh.positions[ends(mesh), 2] > 0
    return np.where(far[:, None, None], scale * rotation_z(angle_rad), np.eye(3))


def off_turn_of_middle(positions: NDArray[np.float64], angle_rad: float) -> float:
    middle = np.abs(MESH.positions[:, 2] - 2) < 0.2
    halves = 0.5 + (MESH.positions[middle, 2] - 2) / 4
    turned = np.array([rotation_z(angle_rad * h) @ p for h, p in zip(halves, MESH.positions[middle], strict=True)])
    return float(np.abs(positions[middle] - turned).max())


@pytest.mark.parametrize("propagation", ["harmonic", "geodesic"])
def test_a_twist_spreads_evenly_and_goes_on_beyond_half_a_turn(propagation):
    model = held_at_ends(propagation=propagation)
    for degrees in range(0, 271, 45):
        angle_rad = np.radians(degrees)
        targets = twisted_ends(MESH, angle_rad)
        result = model.solve(targets, rotations=turns_of_ends(angle_rad))
        assert off_turn_of_middle(result.positions, angle_rad) < CLOSE
        assert result.positions[ends(MESH)] == pytest.approx(targets, abs=1e-14)
    assert (result.stop_reason, result.iterations, model.n_factorizations) == ("converged", 1, 1)
    from_rest = model.solve(targets, arap_native.SolveOptions(initial_guess="rest"))
    assert off_turn_of_middle(from_rest.positions, np.radians(270 - 360)) < CLOSE
    model.reset()
    assert model.positions == pytest.approx(MESH.positions, abs=1e-15)


def test_a_turn_and_a_scale_of_all_handles_are_those_of_the_mesh():
    model = held_at_ends()
    linear = 1.7 * rotation_z(2.5)
    targets = MESH.positions[ends(MESH)] @ linear.T + [1.0, 2.0, 3.0]
    rotations = np.ascontiguousarray(np.broadcast_to(linear, (len(targets), 3, 3)))
    posed = model.solve(targets, rotations=rotations).positions
    assert np.abs(posed - (MESH.positions @ linear.T + [1.0, 2.0, 3.0])).max() < 1e-9 * MESH.diagonal


def test_turns_are_estimated_from_targets():
    targets = twisted_ends(MESH, 1.0)
    given = held_at_ends().solve(targets, rotations=turns_of_ends(1.0)).positions
    assert np.abs(held_at_ends().solve(targets).positions - given).max() < 1e-9


def test_without_turns_the_displacement_is_spread():
    targets = MESH.positions[ends(MESH)]
    targets[targets[:, 2] > 0] += [0.0, 1.0, 0.5]
    posed = held_at_ends().solve(targets, rotations=turns_of_ends(0.0)).positions
    shares = MESH.positions[:, 2:] / 4
    assert np.abs(posed - MESH.positions - shares * [0.0, 1.0, 0.5]).max() < 0.06


def test_it_is_a_model_and_jobs_do_what_the_calls_do():
    targets = twisted_ends(MESH, 1.0)
    called = held_at_ends().solve(targets)
    model = arap_native.PoissonEditing.begin_bind(*MESH).result()
    assert type(model) is arap_native.PoissonEditing
    assert isinstance(model, arap_native.Model)
    assert (model.n_vertices, model.n_parts, model.n_factorizations) == (96, 1, 0)
    assert repr(model).startswith("<PoissonEditing: 96 vertices, 1 part, ")
    assert model.begin_set_constraints(ends(MESH)).result() is None
    assert np.array_equal(model.begin_solve(targets).result().positions, called.positions)
    out = np.zeros((96, 3), np.float32)
    assert model.solve(targets, out=out).positions is out
    assert out == pytest.approx(called.positions, abs=1e-6)
    cancelled = model.solve(2 * targets, progress=lambda _: False)
    assert cancelled.stop_reason == "cancelled"
    assert np.array_equal(cancelled.positions, called.positions)
    model.set_positions(MESH.positions)
    assert model.positions == pytest.approx(MESH.positions, abs=1e-15)


def test_options_are_named_values():
    assert repr(arap_native.PoissonOptions()) == "PoissonOptions(propagation='harmonic', threads=0)"
    options = arap_native.PoissonOptions(propagation="geodesic", threads=2)
    assert arap_native.PoissonEditing(*MESH, options=options).threads == 2
    with pytest.raises(ValueError, match=r"^threads = -1, must be "):
        options.threads = -1
    with pytest.raises(ValueError, match=r"^propagation = 'near', must be one of 'harmonic', 'geodesic'"):
        options.propagation = "near"
    with pytest.raises(TypeError):
        arap_native.PoissonEditing(*MESH, options=arap_native.Options())


def test_what_is_wrong_is_told_in_words():
    with pytest.raises(TypeError, match="stiffness"):
        arap_native.PoissonEditing(*MESH, stiffness=np.ones(96))
    with pytest.raises(arap_native.Cancelled, match=r"^binding was cancelled"):
        arap_native.PoissonEditing(*MESH, progress=lambda _: False)
    model = held_at_ends()
    targets = MESH.positions[ends(MESH)]
    with pytest.raises(ValueError, match=r"^rotations\[0\] has determinant -1, must be above 0"):
        model.solve(targets, rotations=np.tile(-np.eye(3), (len(targets), 1, 1)))
    with pytest.raises(ValueError, match=r"^segments need a model with an inside"):
        model.set_constraints(ends(MESH), segments=np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, 3.0]]]))
