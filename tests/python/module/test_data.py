# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects as data: compared, copied, pickled, rebuilt in another process."""

import copy
import multiprocessing
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from operator import methodcaller
from typing import Any

import arap_native
import numpy as np
import pytest
from sample_meshes import ends, tube, twisted_ends

MESH = tube()
VERTICES = ends(MESH)
CAGE = arap_native.make_cage(*MESH, cells=4)
TETS = arap_native.LatticeTets(*MESH, cube_size=0.2)
OPTIONS = [name for name in arap_native.__all__ if name.endswith("Options")]
MODELS = arap_native.Model.__subclasses__()
COPIES: list[Callable[[Any], Any]] = [copy.copy, copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))]

# Of each class some that are not the defaults.
OTHERS = {
    "Options": {"energy": "spokes", "rigidity_radius": 0.1, "weights": "uniform", "threads": 2, "join_seams": True},
    "LatticeOptions": {"cube_size": 0.1, "keep_volume": 0.5, "threads": 2, "join_seams": True},
    "EmbeddedOptions": {"node_distance": 0.1, "nodes": "rigid", "weights": "nearest", "rotation_weight": 2.0},
    "PoissonOptions": {"propagation": "geodesic", "threads": 2},
    "TetOptions": {"threads": 2},
    "CageOptions": {"coordinates": "harmonic", "grid_spacing": 0.05, "threads": 2},
    "CageArapOptions": {"energy": "cage", "coordinates": "harmonic", "rigidity_radius": 0.1},
    "WrapOptions": {"anchors": 5, "stay_outside": False, "threads": 2},
    "SolveOptions": {"initial_guess": "rest", "acceleration": "none", "max_iterations": 3, "time_limit_s": 0.5},
}


# -------------------------------------------------------------------------------------------- options and results


@pytest.mark.parametrize("name", OPTIONS)
def test_options_are_equal_by_their_values(name):
    kind = getattr(arap_native, name)
    assert kind() == kind()
    assert kind(**OTHERS[name]) == kind(**OTHERS[name])
    for attribute, value in OTHERS[name].items():
        assert kind(**{attribute: value}) != kind()
    assert kind() != "other"
    assert kind() != (arap_native.TetOptions() if name != "TetOptions" else arap_native.WrapOptions())
    with pytest.raises(TypeError, match="unhashable"):
        hash(kind())


@pytest.mark.parametrize("name", OPTIONS)
@pytest.mark.parametrize("copied", COPIES)
def test_options_are_copied_with_all_values(name, copied):
    options = getattr(arap_native, name)(**OTHERS[name])
    again = copied(options)
    assert type(again) is type(options)
    assert again is not options
    assert again == options
    attribute, value = next(iter(OTHERS[name].items()))
    setattr(again, attribute, getattr(type(options)(), attribute))
    assert again != options
    assert getattr(options, attribute) == value


@pytest.mark.parametrize("copied", COPIES)
def test_results_are_copied_with_all_values(copied):
    model = arap_native.SurfaceArap(*MESH)
    model.set_constraints(VERTICES)
    out = np.empty(MESH.positions.shape, np.float32)
    for result in (model.solve(twisted_ends(MESH)), model.solve(twisted_ends(MESH), out=out)):
        again = copied(result)
        assert again == result
        assert repr(again) == repr(result)
        assert again.positions.dtype == result.positions.dtype
        assert (again.stop_reason, again.n_parts, again.n_parts_joined) == ("converged", 1, 1)
        assert np.shares_memory(again.positions, result.positions) == (copied is copy.copy)
        if copied is not copy.copy:
            again.positions[3] += 1
            assert again != result
    assert model.solve(twisted_ends(MESH, 0.2)) != model.solve(twisted_ends(MESH, 0.4))


def test_results_refuse_what_is_none_of_theirs():
    model = arap_native.SurfaceArap(*MESH)
    model.set_constraints(VERTICES)
    result = model.solve(twisted_ends(MESH))
    _, values = result.__reduce__()[1]
    with pytest.raises(ValueError, match="stop_reason = 'bored', must be one of 'converged'"):
        arap_native.SolveResult(**values | {"stop_reason": "bored"})
    with pytest.raises(ValueError, match=r"positions has shape \(3,\), expected \(n, 3\)"):
        arap_native.SolveResult(**values | {"positions": np.zeros(3)})


# -------------------------------------------------------------------------------------------------------- models


def bound(model: type[arap_native.Model]) -> arap_native.Model:
    """With everything that a model may be made of."""
    coarse = {"cube_size": 0.2} if model is arap_native.LatticeArap else {}
    options = {"options": getattr(arap_native, OPTIONS_OF[model])(threads=1, **coarse)}
    if model is arap_native.TetArap:
        stiffness = np.linspace(1, 2, len(TETS.rest_positions))
        return arap_native.TetArap(TETS.rest_positions, TETS.tets, stiffness=stiffness, **options)
    if model is arap_native.CageArap:
        return arap_native.CageArap(*MESH, cage=CAGE, **options)
    if model in (arap_native.SurfaceArap, arap_native.LatticeArap):
        regions = np.where(np.abs(MESH.positions[:, 2] - 2) < 0.5, 0, -1)
        options |= {"stiffness": np.linspace(1, 2, len(MESH.positions)), "rigid_regions": regions}
    return model(*MESH, **options)


OPTIONS_OF = {
    arap_native.SurfaceArap: "Options",
    arap_native.LatticeArap: "LatticeOptions",
    arap_native.PoissonEditing: "PoissonOptions",
    arap_native.EmbeddedDeformation: "EmbeddedOptions",
    arap_native.CageArap: "CageArapOptions",
    arap_native.TetArap: "TetOptions",
}


def posed(model: type[arap_native.Model]) -> tuple[arap_native.Model, np.ndarray]:
    """Held at both ends, the far one softly and with a patch, and moved; with the targets."""
    made = bound(model)
    rest = made.positions
    order = np.argsort(rest[:, 2], kind="stable")
    held = np.concatenate([order[:8], order[-8:]])
    patch = order[len(order) // 2 - 2 : len(order) // 2 + 2]
    strengths = np.where(np.arange(16) < 8, 1.0, 0.9)
    made.set_constraints(held, strengths, ([0, 4], patch, np.full(4, 0.25)))
    targets = np.vstack([rest[held], rest[patch].mean(0)])
    targets[8:] += [0.3, 0.1, 0.2]
    made.solve(targets)
    return made, targets


def expect_same(made: arap_native.Model, again: arap_native.Model, targets: np.ndarray) -> None:
    size = float(np.linalg.norm(np.ptp(made.positions, axis=0)))
    assert type(again) is type(made)
    assert repr(again) == repr(made)
    near = 1e-5 if isinstance(made, arap_native.CageArap) else 1e-9  # as near as a cage can be
    assert np.abs(again.positions - made.positions).max() < near * size
    accurate = arap_native.SolveOptions(initial_guess="rest", accuracy=1e-9)
    expected = made.solve(targets, accurate).positions
    assert np.abs(again.solve(targets, accurate).positions - expected).max() < 1e-8 * size


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("copied", COPIES)
def test_a_model_is_copied_with_its_constraints_and_positions(model, copied):
    made, targets = posed(model)
    expect_same(made, copied(made), targets)


@pytest.mark.parametrize("model", MODELS)
def test_a_model_without_constraints_is_copied_too(model):
    made = bound(model)
    again = copy.copy(made)
    assert "no constraints" in repr(again)
    assert np.array_equal(again.positions, made.positions)
    with pytest.raises(ValueError, match="set_constraints"):
        again.solve(np.zeros((3, 3)))


def test_bones_are_copied():
    made = arap_native.LatticeArap(*MESH)
    segments = np.array([[[0.0, 0.0, 1.0], [0.0, 0.0, 3.0]]])
    made.set_constraints([], segments=segments)
    targets = np.array([[0, 0, 1], [2, 0, 1], [0, 2, 1], [0, 0, 3]]) + 0.5
    made.solve(targets)
    expect_same(made, copy.copy(made), targets)


def test_a_copy_of_a_model_that_is_at_work_is_refused():
    model = arap_native.SurfaceArap(*MESH)
    model.set_constraints(VERTICES)

    def copy_it(_fraction: float) -> None:
        copy.copy(model)

    with pytest.raises(RuntimeError, match="is at work"):
        model.solve(twisted_ends(MESH), progress=copy_it)


def carriers() -> list[Any]:
    points = MESH.positions * 1.2
    surface = arap_native.WrapSurface(*MESH, threads=1)
    pieces = np.where(np.arange(len(points)) < 10, 0, -1)
    return [
        arap_native.CageDeformation(MESH.positions, *CAGE, options=arap_native.CageOptions(coordinates="harmonic")),
        arap_native.WrapDeformation(points, *MESH, options=arap_native.WrapOptions(anchors=5), piece_of_point=pieces),
        surface.bind(points),
        arap_native.WrapDeformation.begin_bind(points, *MESH).result(),
    ]


@pytest.mark.parametrize("copied", COPIES)
def test_what_carries_points_is_copied(copied):
    for carrier in carriers():
        again = copied(carrier)
        moved = CAGE[0] * [1, 2, 1] if isinstance(carrier, arap_native.CageDeformation) else MESH.positions * [1, 2, 1]
        assert repr(again) == repr(carrier)
        assert np.array_equal(again.deform(moved), carrier.deform(moved))
    surface = arap_native.WrapSurface(*MESH, threads=1)
    bound = copied(surface).bind(MESH.positions)
    assert np.array_equal(bound.deform(MESH.positions * 2), surface.bind(MESH.positions).deform(MESH.positions * 2))
    again = copied(TETS)
    assert np.array_equal(again.tets, TETS.tets)
    assert np.array_equal(again.coordinates, TETS.coordinates)


def test_cancelled_is_pickled_by_its_name():
    error = pickle.loads(pickle.dumps(arap_native.Cancelled("stop")))
    assert type(error) is arap_native.Cancelled
    assert str(error) == "stop"


# ----------------------------------------------------------------------------------------------- another process


def test_models_go_to_another_process_and_results_come_back():
    options = arap_native.SolveOptions(initial_guess="rest", accuracy=1e-9)
    tasks = [posed(model) for model in MODELS]
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as there:
        jobs = [there.submit(methodcaller("solve", targets, options), model) for model, targets in tasks]
        results = [job.result() for job in jobs]
    for (model, targets), result in zip(tasks, results, strict=True):
        size = float(np.linalg.norm(np.ptp(result.positions, axis=0)))
        assert result.stop_reason == "converged"
        assert np.abs(result.positions - model.solve(targets, options).positions).max() < 1e-8 * size
