# SPDX-License-Identifier: GPL-3.0-or-later
"""TetArap from the outside: its own input, and what it has in common with the other models."""

from itertools import permutations
from typing import NamedTuple

import arap_native
import numpy as np
import pytest
from numpy.typing import NDArray
from sample_meshes import rotation_z


class Tets(NamedTuple):
    positions: NDArray[np.float64]
    tets: NDArray[np.int32]


def bar(n: int = 2, length: int = 6) -> Tets:
    """n x n x length cubes along z, each cut into six tetrahedra, half of them inside out."""
    counts = np.array([n, n, length])
    corners = np.stack(np.meshgrid(*(np.arange(k + 1) for k in counts), indexing="ij"), axis=-1).reshape(-1, 3)
    steps = np.array([(n + 1) * (length + 1), length + 1, 1])
    first = np.flatnonzero((corners < counts).all(axis=1))
    paths = [np.cumsum([0, *steps[list(axes)]]) for axes in permutations(range(3))]
    return Tets(corners.astype(float), np.concatenate([first[:, None] + path for path in paths]).astype(np.int32))


def ends(mesh: Tets) -> NDArray[np.int32]:
    z = mesh.positions[:, 2]
    return np.concatenate([np.flatnonzero(z == 0), np.flatnonzero(z == z.max())]).astype(np.int32)


def twisted_ends(mesh: Tets, angle_rad: float = 1.0) -> NDArray[np.float64]:
    held = mesh.positions[ends(mesh)]
    far = held[:, 2] > 0
    middle = np.array([*mesh.positions[:, :2].mean(axis=0), 0.0])
    held[far] = (held[far] - middle) @ rotation_z(angle_rad).T + middle
    return held


def held_at_ends(mesh: Tets, **keywords) -> arap_native.TetArap:
    model = arap_native.TetArap(*mesh, **keywords)
    model.set_constraints(ends(mesh))
    return model


def test_it_twists_a_bar():
    mesh = bar()
    result = held_at_ends(mesh).solve(twisted_ends(mesh))
    assert result.stop_reason == "converged"
    assert result.positions[ends(mesh)] == pytest.approx(twisted_ends(mesh), abs=1e-12)
    middle = np.array([1.0, 1.0, 0.0])
    layer = mesh.positions[:, 2] == 3
    turned = (mesh.positions - middle) @ rotation_z(0.5).T + middle
    assert np.abs(result.positions - turned)[layer].max() < 0.1, "in the middle it turns by half"


def test_energy_of_a_stretch_is_volume_times_its_square():
    mesh = bar()
    model = arap_native.TetArap(*mesh)
    stretched = mesh.positions * [1.0, 1.0, 1.5]
    assert model.energy(stretched) == pytest.approx(24 * 0.25)
    assert model.energy(mesh.positions @ rotation_z(2.0).T) == pytest.approx(0, abs=1e-12)
    assert model.energy_gradient(stretched).sum(axis=0) == pytest.approx(0, abs=1e-12)
    stiff = arap_native.TetArap(*mesh, stiffness=np.full(len(mesh.positions), 3.0))
    assert stiff.energy(stretched) == pytest.approx(3 * 24 * 0.25)


def test_it_is_a_model_and_jobs_do_what_the_calls_do():
    mesh = bar()
    called = held_at_ends(mesh).solve(twisted_ends(mesh))
    model = arap_native.TetArap.begin_bind(*mesh).result()
    assert type(model) is arap_native.TetArap
    assert isinstance(model, arap_native.Model)
    assert (model.n_vertices, model.n_parts, model.n_factorizations) == (63, 1, 0)
    assert repr(model).startswith("<TetArap: 63 vertices, 1 part, ")
    assert model.begin_set_constraints(ends(mesh)).result() is None
    assert np.array_equal(model.begin_solve(twisted_ends(mesh)).result().positions, called.positions)
    loose = arap_native.TetArap(np.vstack([mesh.positions, [[9.0, 9.0, 9.0]]]), mesh.tets)
    assert (loose.loose_vertices.tolist(), loose.part_of_vertex[-1]) == ([63], -1)


def test_a_rigid_region_keeps_its_shape():
    mesh = bar()
    middle = np.abs(mesh.positions[:, 2] - 3) < 1.5
    model = held_at_ends(mesh, rigid_regions=np.where(middle, 0, -1).astype(np.int32))
    posed, rest = model.solve(twisted_ends(mesh)).positions[middle], mesh.positions[middle]
    lengths, rest_lengths = (np.linalg.norm(p[:, None] - p[None], axis=-1) for p in (posed, rest))
    assert np.abs(lengths - rest_lengths).max() < 1e-10


def test_options_are_named_values():
    assert repr(arap_native.TetOptions()) == "TetOptions(threads=0)"
    options = arap_native.TetOptions(threads=2)
    assert arap_native.TetArap(*bar(), options=options).threads == 2
    with pytest.raises(ValueError, match=r"^threads = -1, must be "):
        options.threads = -1
    with pytest.raises(TypeError):
        arap_native.TetArap(*bar(), options=arap_native.Options())


def test_what_is_wrong_is_told_in_words():
    positions, tets = bar()
    with pytest.raises(ValueError, match=r"^tets has shape \(144, 3\), expected \(m, 4\): one row per tetrahedron"):
        arap_native.TetArap(positions, tets[:, :3])
    tets[5, 2] = 63
    with pytest.raises(ValueError, match=r"^tetrahedron 5 .* names vertex 63, but the mesh has vertices 0 to 62"):
        arap_native.TetArap(positions, tets)
    with pytest.raises(ValueError, match=r"^tetrahedron 0 .* has no volume"):
        arap_native.TetArap(positions * [1.0, 1.0, 0.0], bar().tets)
