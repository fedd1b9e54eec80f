# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a new handle pulls, so that the force on each vertex is as before."""

import numpy as np
import pytest
from arap_deform.core.targets import HandleSpec
from arap_deform.core.unbound import Moved, staying_targets
from sample_meshes import motion

REST = np.random.default_rng(1).normal(size=(4, 3))
SHOWN = REST + 0.5


def hold(vertices, weight, base=None):
    return HandleSpec("Hold", np.asarray(vertices, np.int32), np.full(len(vertices), weight), base=base)


def force(target, weight):
    return weight / (1.0 - weight) * (target - SHOWN[1])


def test_what_no_other_handle_holds_is_pulled_to_where_it_is():
    np.testing.assert_allclose(staying_targets(hold([0, 2], 1.0), [], REST, SHOWN), SHOWN[[0, 2]])


@pytest.mark.parametrize(("former", "new"), [(0.3, 0.3), (0.3, 0.8), (0.8, 0.3)])
def test_soft_holds_together_pull_as_the_former_one(former, new):
    move = motion(shift=(1.0, 2.0, 3.0))
    target = staying_targets(hold([1], new), [Moved(hold([0, 1], former), move)], REST, SHOWN)[0]
    before = REST[1] + move[:3, 3]
    mean = (former * before + new * target) / (former + new)
    np.testing.assert_allclose(force(mean, max(former, new)), force(before, former))


def test_a_hard_vertex_stays_where_it_is_whatever_a_soft_hold_wants():
    target = staying_targets(hold([1], 1.0), [Moved(hold([1], 0.3), np.eye(4))], REST, SHOWN)[0]
    np.testing.assert_allclose((0.3 * REST[1] + target) / 1.3, SHOWN[1])


def test_what_is_held_hard_stays_where_it_is_pulled_to():
    there = Moved(hold([1], 1.0, base=REST + 0.1), motion(shift=(0.4, 0.4, 0.4)))
    for weight in (1.0, 0.3):
        target = staying_targets(hold([1], weight), [there], REST, SHOWN)[0]
        np.testing.assert_allclose((REST[1] + 0.5 + weight * target) / (1.0 + weight), REST[1] + 0.5)
