# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays as arguments: what is read as the same, and every message about what is not."""

from collections.abc import Callable
from typing import Any

import arap_native
import numpy as np
import pytest
from sample_meshes import ends, sheet, tube, twisted_ends

MESH = tube()
VERTICES = ends(MESH)
TARGETS = twisted_ends(MESH)
POSED = arap_native.SurfaceArap(*MESH)
POSED.set_constraints(VERTICES)
EXPECTED = POSED.solve(TARGETS).positions

# Quads alone, in whole numbers, so that every dtype holds them.
SHEET = sheet(5)
POSITIONS = SHEET.positions * 2
QUADS = SHEET.corner_vertices.reshape(-1, 4)


def unaligned(array: np.ndarray) -> np.ndarray:
    return np.frombuffer(b"x" + array.tobytes(), array.dtype, offset=1).reshape(array.shape)


def spread(array: np.ndarray) -> np.ndarray:
    return np.repeat(array, 2, axis=0)[::2]


ORDERS: list[Callable[[np.ndarray], Any]] = [np.asfortranarray, spread, unaligned, np.ndarray.tolist, tuple]


def energy_of(positions: Any, *faces: Any) -> float:
    return arap_native.SurfaceArap(positions, *faces).energy(POSITIONS * [1.0, 2.0, 1.0])


ENERGY = energy_of(POSITIONS, SHEET.corner_vertices, SHEET.face_sizes)


@pytest.mark.parametrize("dtype", ["f2", "f4", "f8", "g", ">f8", "i1", "i4", "i8", ">i2"])
def test_numbers_of_any_dtype_are_positions(dtype):
    assert energy_of(POSITIONS.astype(dtype), QUADS) == ENERGY


@pytest.mark.parametrize("dtype", ["i1", "i2", "i4", "i8", "u1", "u2", "u4", "u8", ">i4", ">u8"])
def test_integers_of_any_dtype_are_faces(dtype):
    assert energy_of(POSITIONS, QUADS.astype(dtype)) == ENERGY


@pytest.mark.parametrize("changed", ORDERS)
def test_any_order_is_read(changed):
    assert energy_of(changed(POSITIONS), changed(QUADS)) == ENERGY
    assert energy_of(changed(POSITIONS), changed(QUADS.astype(np.int64))) == ENERGY


def test_faces_are_rows_or_lists_or_flat():
    assert energy_of(POSITIONS, [*QUADS]) == ENERGY
    assert energy_of(POSITIONS, [QUADS[0].astype(np.uint64), *QUADS[1:].tolist()]) == ENERGY
    assert energy_of(POSITIONS, QUADS.ravel().tolist(), [4] * len(QUADS)) == ENERGY
    *others, first, second = QUADS.tolist()
    mixed = [*others, first[:3], [first[0], *first[2:]], np.array(second)]
    flat, sizes = [vertex for face in mixed for vertex in face], [len(face) for face in mixed]
    assert energy_of(POSITIONS, mixed) == energy_of(POSITIONS, flat, sizes)
    corners, n_vertices = MESH.corner_vertices, len(MESH.positions)
    polygons = [face.tolist() for face in np.split(corners, np.cumsum(MESH.face_sizes)[:-1])]
    assert arap_native.SurfaceArap(MESH.positions, polygons).n_vertices == n_vertices
    assert arap_native.SurfaceArap(MESH.positions, polygons).energy(EXPECTED) == POSED.energy(EXPECTED)


def test_all_other_arguments_are_read_so():
    model = arap_native.SurfaceArap(
        MESH.positions.tolist(),
        MESH.corner_vertices.astype(np.int64),
        MESH.face_sizes.tolist(),
        stiffness=np.ones(96, np.uint8),
        rigid_regions=[-1] * 96,
    )
    model.set_constraints(VERTICES.tolist(), [1] * len(VERTICES))
    rotations = np.asfortranarray(np.broadcast_to(np.eye(3, dtype=np.float32), (16, 3, 3)))
    posed = model.solve(np.asfortranarray(TARGETS), rotations=rotations).positions
    assert posed == pytest.approx(EXPECTED, abs=1e-5)
    model.set_positions(EXPECTED.tolist())
    assert model.energy(EXPECTED.tolist()) == POSED.energy(EXPECTED)
    model.set_constraints([], patches=([0, 2], [20, 21], [1, 1]))
    assert model.begin_patches([[20], np.array([21])], [0.1, 0.1]).result()[1][0][0] == 21


def test_what_is_given_stays_as_it_is():
    positions, faces = POSITIONS.astype(np.float32), QUADS.astype(np.uint32)
    positions.flags.writeable = faces.flags.writeable = False
    assert energy_of(positions, faces) == ENERGY


# -------------------------------------------------------------------------------------------------- what is refused


def message(error: type[Exception], call: Callable[..., Any], *arguments: Any, **keywords: Any) -> str:
    with pytest.raises(error) as caught:
        call(*arguments, **keywords)
    assert caught.type is error
    return str(caught.value)


@pytest.mark.parametrize(
    ("positions", "error", "expected"),
    [
        (None, TypeError, "is of type NoneType, expected an array of real numbers, or what numpy.asarray() makes one"),
        ("flat", TypeError, "is of type str, expected an array of real numbers, or what numpy.asarray() makes one"),
        (
            [[0, 1, 2], [3]],
            TypeError,
            "is of type list, expected an array of real numbers, or what numpy.asarray() makes one",
        ),
        (POSITIONS.astype(complex), ValueError, "has dtype complex128, expected real numbers"),
        (POSITIONS.astype(object), ValueError, "has dtype object, expected real numbers"),
        (POSITIONS.astype(str), ValueError, "has dtype <U32, expected real numbers"),
        (POSITIONS > 0, ValueError, "has dtype bool, expected real numbers"),
        (3.0, ValueError, "has shape (), expected (n, 3): one row per vertex"),
        (POSITIONS.ravel(), ValueError, "has shape (75,), expected (n, 3): one row per vertex"),
        (POSITIONS[:, :2], ValueError, "has shape (25, 2), expected (n, 3): one row per vertex"),
    ],
)
def test_what_is_wrong_with_positions(positions, error, expected):
    assert message(error, arap_native.SurfaceArap, positions, QUADS) == f"rest_positions {expected}"


BOUNDS = "must be from -2147483648 to 2147483647"


@pytest.mark.parametrize(
    ("vertices", "error", "expected"),
    [
        (None, TypeError, "is of type NoneType, expected an array of integers, or what numpy.asarray() makes one"),
        ([0.0, 1.0], ValueError, "has dtype float64, expected integers"),
        (np.zeros(3, np.float32), ValueError, "has dtype float32, expected integers"),
        (np.zeros(96, bool), ValueError, "has dtype bool, expected integers: indices, not a mask"),
        ([5, 2**31], ValueError, f"has the entry 2147483648 at place 1, {BOUNDS}"),
        ([5, 2**63], ValueError, f"has the entry 9223372036854775808 at place 1, {BOUNDS}"),
        ([2**64], ValueError, f"has the entry 18446744073709551616 at place 0, {BOUNDS}"),
        ([5, np.int64(2**40)], ValueError, f"has the entry 1099511627776 at place 1, {BOUNDS}"),
        ([5, True], ValueError, "has the entry True at place 1, expected integers"),
        ((5, np.False_), ValueError, "has the entry False at place 1, expected integers"),
        (
            np.ma.masked_equal([5, 6], 6),
            ValueError,
            "has masked values, expected an array without: fill them or leave them out",
        ),
        (np.array([[0, -(2**40)]]).T, ValueError, f"has the entry -1099511627776 at place 1, {BOUNDS}"),
        (np.array([2**64 - 1], np.uint64), ValueError, f"has the entry 18446744073709551615 at place 0, {BOUNDS}"),
    ],
)
def test_what_is_wrong_with_indices(vertices, error, expected):
    assert message(error, POSED.set_constraints, vertices) == f"vertices {expected}"


def test_what_is_wrong_with_faces():
    def said(error: type[Exception], *faces: Any) -> str:
        return message(error, arap_native.SurfaceArap, POSITIONS, *faces)

    flat, sizes = SHEET.corner_vertices, SHEET.face_sizes
    assert (
        said(ValueError, flat) == "faces has shape (64,), expected (m, k): one row per face; flat faces need face_sizes"
    )
    assert said(TypeError, flat.tolist()) == (
        "faces[0] is of type int, expected a list of vertices: flat faces need face_sizes"
    )
    assert said(ValueError, QUADS[:, :2]) == "faces has shape (16, 2), expected three or more vertices in a row"
    assert said(ValueError, [[0, 1, 2], [3, 4]]) == "face_sizes[1] = 2, must be >= 3"
    assert said(ValueError, [[0, 1, 2], [3, 4, True]]) == "faces has the entry True at place 5, expected integers"
    assert said(ValueError, [[[0, 1, 2], [3, 4, 5]]]) == (
        "faces has shape (2, 3), expected (c,): one number per vertex of a face"
    )
    assert said(ValueError, QUADS, sizes) == (
        "faces has shape (16, 4), expected (c,): one face after the other, as face_sizes says how long each is"
    )
    assert said(ValueError, flat, sizes[:, None]) == "face_sizes has shape (16, 1), expected (f,): one entry per face"
    assert said(ValueError, flat[1:], sizes) == "the faces have 63 corners, but face_sizes adds up to 64 or more"


@pytest.mark.parametrize("name", ["strengths", "targets", "rotations", "stiffness", "positions", "segments"])
def test_every_array_of_numbers_is_named(name):
    calls: dict[str, Callable[[Any], Any]] = {
        "strengths": lambda given: POSED.set_constraints(VERTICES, given),
        "targets": POSED.solve,
        "rotations": lambda given: POSED.solve(TARGETS, rotations=given),
        "stiffness": lambda given: arap_native.SurfaceArap(*MESH, stiffness=given),
        "positions": POSED.set_positions,
        "segments": lambda given: POSED.set_constraints(VERTICES, segments=given),
    }
    assert message(ValueError, calls[name], np.zeros(3, complex)).startswith(f"{name} has dtype complex128")


@pytest.mark.parametrize("name", ["faces", "face_sizes", "rigid_regions", "tets"])
def test_every_array_of_integers_is_named(name):
    calls: dict[str, Callable[[Any], Any]] = {
        "faces": lambda given: arap_native.SurfaceArap(POSITIONS, given),
        "face_sizes": lambda given: arap_native.SurfaceArap(*SHEET[:2], given),
        "rigid_regions": lambda given: arap_native.SurfaceArap(*MESH, rigid_regions=given),
        "tets": lambda given: arap_native.TetArap(POSITIONS, given),
    }
    assert message(ValueError, calls[name], np.zeros(3)).startswith(f"{name} has dtype float64")
