# SPDX-License-Identifier: GPL-3.0-or-later
"""Every kind of bad mesh, small; they hardly depend on the version of Python. The long runs are in tests/attack."""

import measure_zoo
import pytest
import zoo


@pytest.mark.parametrize("model", ["surface", "poisson"])
@pytest.mark.parametrize("kind", zoo.KINDS)
def test_a_bad_mesh_stays_finite_and_at_rest(model, kind):
    row = measure_zoo.attack(model, kind, 300, threads=1)
    assert row["what"] == "ok"


@pytest.mark.parametrize("kind", zoo.KINDS)
def test_a_lattice_takes_all_but_what_has_no_faces_or_no_size(kind):
    row = measure_zoo.attack("lattice", kind, 60, threads=1)
    refused = {"nothing_but_loose": "no faces", "one_point": "no size"}
    assert refused.get(kind, "ok") in row["what"]


@pytest.mark.parametrize("kind", zoo.KINDS)
def test_a_graph_lies_on_all_but_what_has_no_faces_or_no_size(kind):
    row = measure_zoo.attack("embedded", kind, 300, threads=1)
    refused = {"nothing_but_loose": "no faces", "one_point": "no size"}
    assert refused.get(kind, "ok") in row["what"]
