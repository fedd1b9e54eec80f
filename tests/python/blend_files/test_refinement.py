# SPDX-License-Identifier: GPL-3.0-or-later
"""The same pose on one surface at two densities, or at two in one: rotation nodes converge, plain ARAP does not."""

import numpy as np
import pytest
from arap_native import Options
from measure.kinds import dense_half
from measure.poses import bar_bend, bar_twist, finer, pull
from measure.posing import Posing

CLOSE = 0.005  # of the diagonal
RADIUS = 0.05  # two and a half edges of the coarse bar


def distance_between(pose, denser, options):
    """Of the vertices that both have, the largest, as a fraction of the diagonal."""
    coarse, fine = (Posing(at, options).pose(at.steps, limit_s=120.0) for at in (pose, denser))
    assert coarse.is_converged
    assert fine.is_converged
    n = len(coarse.positions)
    return np.linalg.norm(fine.positions[:n] - coarse.positions, axis=1).max()


@pytest.fixture(params=[bar_bend, bar_twist], ids=["bend", "twist"])
def pose(request):
    return request.param()


def test_rotation_nodes_converge_under_refinement(pose):
    assert distance_between(pose, finer(pose), Options(energy="rotation_nodes", rigidity_radius=RADIUS)) < CLOSE


def test_plain_arap_does_not(pose):
    assert distance_between(pose, finer(pose), Options(energy="spokes_and_rims")) > 10 * CLOSE


def test_rotation_nodes_do_not_see_where_a_surface_is_denser():
    bump = pull("", patch_radius=0.03)
    assert distance_between(bump, dense_half(bump), Options(energy="rotation_nodes")) < CLOSE / 2
    assert distance_between(bump, dense_half(bump), Options(energy="spokes_and_rims")) > 2 * CLOSE
