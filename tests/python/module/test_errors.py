# SPDX-License-Identifier: GPL-3.0-or-later
"""Every message of the binding's own checks, once; of what the library refuses, a sample."""

import arap_native
import numpy as np
import pytest
from sample_meshes import ends, tube, twisted_ends

MESH = tube()
VERTICES = ends(MESH)
STRENGTHS = np.ones(len(VERTICES))
OPTION_NAMES = "energy, rigidity_radius, weights, threads, join_seams"
PATCH = (np.array([0, 2], np.int32), np.array([20, 21], np.int32), np.ones(2))


@pytest.fixture
def solver() -> arap_native.SurfaceArap:
    made = arap_native.SurfaceArap(*MESH)
    made.set_constraints(VERTICES, STRENGTHS)
    return made


def message(error: type[Exception], call, *arguments, **keywords) -> str:
    with pytest.raises(error) as caught:
        call(*arguments, **keywords)
    assert caught.type is error
    return str(caught.value)


# ------------------------------------------------------------------------------------------ arrays: see test_arrays


def test_what_is_wrong_with_an_array_to_write_to(solver):
    def said(out) -> str:
        return message(ValueError, solver.solve, MESH.positions[VERTICES], out=out)

    good = np.zeros(MESH.positions.shape, np.float32)
    assert message(TypeError, solver.solve, MESH.positions[VERTICES], out=good.tolist()) == (
        "out is of type list, expected a numpy array of float32"
    )
    assert said(good.astype(np.float64)) == "out has dtype float64, expected float32"
    assert said(good.astype(">f4")) == "out has dtype >f4, expected float32"
    assert said(np.asfortranarray(good)) == (
        "out is not C-contiguous, expected rows one after the other: pass an array made by numpy"
    )
    assert said(good[:-1].copy()) == "out has shape (95, 3), expected (96, 3): one row per vertex"
    odd = np.frombuffer(bytearray(good.nbytes + 1), np.float32, offset=1).reshape(good.shape)
    assert said(odd) == "out is not aligned, expected numbers at multiples of their size: pass an array made by numpy"
    good.flags.writeable = False
    assert said(good) == "out is read-only, expected an array that can be written to"


def test_lengths_of_vertex_properties():
    bind = arap_native.SurfaceArap
    assert message(ValueError, bind, *MESH, stiffness=np.ones(5)) == (
        "stiffness has shape (5,), expected (96,): one entry per vertex"
    )
    assert message(ValueError, bind, *MESH, rigid_regions=np.zeros(5, np.int32)) == (
        "rigid_regions has shape (5,), expected (96,): one entry per vertex"
    )


def test_shapes_of_constraints(solver):
    assert message(ValueError, solver.set_constraints, VERTICES[:, None], STRENGTHS) == (
        "vertices has shape (16, 1), expected (k,): one entry per constrained vertex"
    )
    assert message(ValueError, solver.set_constraints, VERTICES, STRENGTHS[:3]) == (
        "strengths has shape (3,), expected (16,): one entry per constrained vertex"
    )


@pytest.mark.parametrize(
    ("patches", "error", "expected"),
    [
        (PATCH[0], TypeError, "patches is not a tuple of three arrays, expected (offsets, vertices, weights)"),
        (PATCH[:2], TypeError, "patches is not a tuple of three arrays, expected (offsets, vertices, weights)"),
        ((PATCH[0].astype(float), *PATCH[1:]), ValueError, "patch offsets has dtype float64, expected integers"),
        (
            (PATCH[0][None], *PATCH[1:]),
            ValueError,
            "patch offsets has shape (1, 2), expected (n_patches + 1,): where each patch begins, and the end",
        ),
        (
            (PATCH[0], PATCH[1][None], PATCH[2]),
            ValueError,
            "patch vertices has shape (1, 2), expected (e,): one entry per vertex of a patch",
        ),
        (
            (*PATCH[:2], np.ones(3)),
            ValueError,
            "patch weights has shape (3,), expected (2,): one entry per vertex of a patch",
        ),
    ],
)
def test_shapes_of_patches(solver, patches, error, expected):
    assert message(error, solver.set_constraints, VERTICES, STRENGTHS, patches) == expected


def test_shapes_of_targets_and_positions(solver):
    solver.set_constraints(VERTICES[:4], STRENGTHS[:4], PATCH)
    assert message(ValueError, solver.solve, np.zeros((3, 2))) == (
        "targets has shape (3, 2), expected (5, 3): one row per constrained vertex, then one per patch, "
        "then four per segment"
    )
    assert message(ValueError, solver.solve, np.zeros((5, 3)), rotations=np.zeros((4, 3, 3))) == (
        "rotations has shape (4, 3, 3), expected (5, 3, 3): one matrix per row of targets"
    )
    expected = "positions has shape (95, 3), expected (96, 3): one row per vertex"
    assert message(ValueError, solver.set_positions, MESH.positions[1:]) == expected
    assert message(ValueError, solver.energy, MESH.positions[1:]) == expected
    assert message(ValueError, solver.energy_gradient, MESH.positions[1:]) == expected


def test_patch_around_names_what_is_wrong(solver):
    assert message(ValueError, solver.patch_around, np.array([96], np.int32)) == (
        "vertex 96 is out of range, the mesh has vertices 0 to 95"
    )
    assert message(ValueError, solver.patch_around, np.array([0], np.int32), -1.0) == (
        "radius = -1, must be finite and >= 0; 0 is the default"
    )


# ------------------------------------------------------------------------------------------- options and callbacks


def test_options_list_the_valid_names():
    assert message(ValueError, arap_native.Options, energy="arap") == (
        "energy = 'arap', must be one of 'rotation_nodes', 'spokes_and_rims', 'spokes'"
    )
    assert message(ValueError, arap_native.Options, weights="cot") == (
        "weights = 'cot', must be one of 'cotangent', 'uniform'"
    )
    guesses = "'previous', 'rest', 'naive_laplacian', 'handle_rotations'"
    assert message(ValueError, arap_native.SolveOptions, initial_guess="") == (
        f"initial_guess = '', must be one of {guesses}"
    )
    assert message(ValueError, setattr, arap_native.SolveOptions(), "initial_guess", "no") == (
        f"initial_guess = 'no', must be one of {guesses}"
    )
    assert message(ValueError, arap_native.SolveOptions, acceleration="anderson") == (
        "acceleration = 'anderson', must be one of 'conjugate_gradients', 'none'"
    )


def test_an_instruction_set_that_is_not_there_is_refused_at_bind(monkeypatch):
    monkeypatch.setenv("ARAP_ISA", "mmx")
    text = message(ValueError, arap_native.SurfaceArap, *MESH)
    assert text.startswith("ARAP_ISA = mmx, must be ")
    assert "baseline" in text


@pytest.mark.parametrize(
    ("keywords", "expected"),
    [
        ({"threads": "x"}, "threads = 'x' is of type str, expected int"),
        ({"threads": 2.5}, "threads = 2.5 is of type float, expected int"),
        ({"energy": None}, "energy = None is of type NoneType, expected str"),
        ({"__repr__": 1}, f"Options() got an unexpected keyword argument '__repr__'; it takes {OPTION_NAMES}"),
    ],
)
def test_an_option_of_a_wrong_type_is_named(keywords, expected):
    assert message(TypeError, arap_native.Options, **keywords) == expected


def test_an_attribute_that_is_no_option_is_refused():
    with pytest.raises(AttributeError):
        arap_native.SolveOptions().max_iteration = 3


def test_progress_has_to_be_callable(solver):
    expected = "progress is of type int, expected a callable or None"
    assert message(TypeError, arap_native.SurfaceArap, *MESH, progress=3) == expected
    assert message(TypeError, solver.set_constraints, VERTICES, STRENGTHS, progress=3) == expected
    assert message(TypeError, solver.solve, twisted_ends(MESH), progress=3) == expected


# -------------------------------------------------------------------------- the library's refusals, as Python sees them


def test_bad_values_are_value_errors_that_name_the_place(solver):
    bad = MESH.positions.copy()
    bad[17, 1] = np.nan
    assert "vertex 17" in message(ValueError, arap_native.SurfaceArap, bad, *MESH[1:])
    assert "stiffness" in message(ValueError, arap_native.SurfaceArap, *MESH, stiffness=np.zeros(96))
    assert "vertex 17" in message(ValueError, solver.set_positions, bad)
    assert "strengths[0] = 2" in message(ValueError, solver.set_constraints, VERTICES, STRENGTHS * 2)
    assert "targets" in message(ValueError, solver.solve, np.full((16, 3), np.inf))
    rotations = np.full((16, 3, 3), np.nan)
    assert "rotations" in message(ValueError, solver.solve, twisted_ends(MESH), rotations=rotations)
    assert message(ValueError, arap_native.Options, threads=-1).startswith("threads = -1, must be ")
    assert message(ValueError, arap_native.SolveOptions, accuracy=-1.0).startswith("accuracy = -1, must be ")


def test_empty_arrays_are_refused_with_what_is_missing(solver):
    no_positions, no_indices = np.zeros((0, 3)), np.zeros(0, np.int32)
    assert "rest_positions is empty" in message(
        ValueError, arap_native.SurfaceArap, no_positions, no_indices, no_indices
    )
    assert "nothing is constrained" in message(ValueError, solver.set_constraints, no_indices, np.zeros(0))
    assert message(ValueError, solver.solve, no_positions) == (
        "targets has shape (0, 3), expected (16, 3): one row per constrained vertex, then one per patch, "
        "then four per segment"
    )


def test_a_mesh_without_faces_is_all_loose_vertices():
    no_triangles = np.zeros((0, 3), np.int32)
    solver = arap_native.SurfaceArap(MESH.positions, no_triangles)
    assert solver.n_parts == 0
    assert len(solver.loose_vertices) == 96


def test_solving_without_constraints_says_what_to_do():
    solver = arap_native.SurfaceArap(*MESH)
    assert "set_constraints" in message(ValueError, solver.solve, np.zeros((3, 3)))
