# SPDX-License-Identifier: GPL-3.0-or-later
"""CageArap from the outside: its own input, and what it has in common with the other models."""

import arap_native
import numpy as np
import pytest
from arap_native import CageArap, CageArapOptions
from sample_meshes import ends, rotation_z, tube, twisted_ends

MESH = tube(rings=20, segments=12)
CAGE = arap_native.make_cage(*MESH, cells=8)


@pytest.mark.parametrize("energy", ["cage", "mesh"])
@pytest.mark.parametrize("coordinates", ["mean_value", "harmonic"])
def test_handles_move_the_mesh_through_its_cage(energy, coordinates):
    model = CageArap(*MESH, options=CageArapOptions(energy=energy, coordinates=coordinates), cage=CAGE)
    model.set_constraints(ends(MESH))
    assert model.solve(MESH.positions[ends(MESH)]).positions == pytest.approx(MESH.positions, abs=1e-9)
    turned = MESH.positions @ rotation_z(1.0).T + 3.0
    result = model.solve(np.ascontiguousarray(turned[ends(MESH)]), arap_native.SolveOptions(accuracy=1e-11))
    assert result.positions == pytest.approx(turned, abs=1e-9)
    assert model.cage_positions() == pytest.approx(CAGE[0] @ rotation_z(1.0).T + 3.0, abs=1e-8)
    result = model.solve(twisted_ends(MESH, 1.0))
    assert np.abs(result.positions[ends(MESH)] - twisted_ends(MESH, 1.0)).max() < 2e-3 * MESH.diagonal
    out = np.empty_like(MESH.positions, dtype=np.float32)
    assert model.solve(twisted_ends(MESH, 1.0), out=out).positions is out
    assert out == pytest.approx(model.positions, abs=1e-6)


def test_it_is_a_model_as_the_others():
    model = CageArap.begin_bind(*MESH, cage=CAGE).result()
    assert type(model) is CageArap
    assert isinstance(model, arap_native.Model)
    assert (model.n_vertices, model.n_cage_vertices, model.n_parts) == (len(MESH.positions), len(CAGE[0]), 1)
    assert repr(model).startswith(f"<CageArap: {len(MESH.positions)} vertices, 1 part, ")
    with pytest.raises(arap_native.Cancelled, match="binding was cancelled"):
        CageArap(*MESH, cage=CAGE, progress=lambda _: False)


def test_what_is_wrong_is_told_in_words():
    with pytest.raises(ValueError, match=r"^energy = 'solid', must be one of 'mesh', 'cage'"):
        CageArapOptions(energy="solid")
    with pytest.raises(ValueError, match=r"^the cage is not closed: "):
        CageArap(*MESH, cage=(CAGE[0], CAGE[1][1:]))
