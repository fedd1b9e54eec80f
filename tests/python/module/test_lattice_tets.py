# SPDX-License-Identifier: GPL-3.0-or-later
"""LatticeTets from the outside: arrays in and out, patches for a TetArap, errors. How it cuts: tests/native."""

import arap_native
import numpy as np
import pytest
from arap_native import LatticeTets
from sample_meshes import ends, tube, twisted_ends

LOOSE = [5.0, 6.0, 7.0]


def with_a_loose_vertex() -> LatticeTets:
    mesh = tube()
    return LatticeTets(np.vstack([mesh.positions, LOOSE]), mesh.corner_vertices, mesh.face_sizes)


def test_coordinates_say_where_vertices_are():
    mesh, tets = tube(), with_a_loose_vertex()
    n = len(mesh.positions)
    assert repr(tets) == f"<LatticeTets: {len(tets.tets)} tetrahedra, {n + 1} vertices of the surface>"
    assert (tets.tets.dtype, tets.tets.shape[1], tets.tet_of_vertex.dtype) == (np.int32, 4, np.int32)
    assert (tets.tet_of_vertex[n], tets.coordinates[n].tolist()) == (-1, [0, 0, 0, 0])
    corners = tets.rest_positions[tets.tets[tets.tet_of_vertex[:n]]]
    assert np.einsum("nk,nkx->nx", tets.coordinates[:n], corners) == pytest.approx(mesh.positions, abs=1e-12)


def test_a_surface_goes_with_them_and_loose_vertices_stay():
    tets = with_a_loose_vertex()
    posed = tets.embed(2 * tets.rest_positions)
    assert posed[:-1] == pytest.approx(2 * tube().positions, abs=1e-12)
    assert posed[-1].tolist() == LOOSE


def test_patches_hold_vertices_of_the_surface():
    mesh = tube()
    tets = LatticeTets(*mesh)
    patches = tets.patches(ends(mesh))
    assert [array.shape[0] for array in patches] == [len(ends(mesh)) + 1, 4 * len(ends(mesh)), 4 * len(ends(mesh))]
    model = arap_native.TetArap(tets.rest_positions, tets.tets)
    model.set_constraints(np.empty(0, np.int32), patches=patches)
    posed = tets.embed(model.solve(twisted_ends(mesh)).positions)
    assert posed[ends(mesh)] == pytest.approx(twisted_ends(mesh), abs=1e-8)
    assert [len(array) for array in tets.patches(np.empty(0, np.int32))] == [1, 0, 0]


def test_larger_cubes_are_fewer():
    assert len(LatticeTets(*tube(), cube_size=0.2).tets) < len(LatticeTets(*tube(), cube_size=0.1).tets)


def test_what_is_wrong_is_told_in_words():
    tets = with_a_loose_vertex()
    with pytest.raises(ValueError, match=r"^of_tets has shape \(2, 3\), .*: one row per vertex of the tetrahedra"):
        tets.embed(np.zeros((2, 3)))
    with pytest.raises(ValueError, match=r"in no face"):
        tets.patches(np.array([0, len(tube().positions)], np.int32))
