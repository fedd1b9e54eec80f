# SPDX-License-Identifier: GPL-3.0-or-later
"""The same pose on a surface that is denser in one half: plain ARAP sees that, rotation nodes do not."""

import numpy as np
from measure.inputs.kinds import dense_half
from measure.inputs.poses import pull
from measure.runs.posing import Posing

CLOSE = 0.0025  # of the diagonal


def difference(pose, denser, model):
    """The largest distance between vertices that both have, as a fraction of the diagonal."""
    coarse, fine = (Posing(at, model).pose(at.steps, limit_s=120.0) for at in (pose, denser))
    assert coarse.is_converged
    assert fine.is_converged
    n = len(coarse.positions)
    return np.linalg.norm(fine.positions[:n] - coarse.positions, axis=1).max()


def test_rotation_nodes_do_not_see_where_a_surface_is_denser():
    bump = pull("", patch_radius=0.03)
    assert difference(bump, dense_half(bump), "nodes") < CLOSE
    assert difference(bump, dense_half(bump), "plain") > 4 * CLOSE
