# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a new handle pulls, so that the force on each vertex is as before."""

import numpy as np
import pytest
from arap_deform.core.unbound import Pulls

SHOWN = np.random.default_rng(1).normal(size=(4, 3))
PLACES = SHOWN + np.random.default_rng(2).normal(size=(4, 3))  # to which other handles pull


def pulls(*handles):
    """The pulls of handles: vertices and their weight."""
    result = Pulls(4)
    for vertices, weight in handles:
        result.add(np.asarray(vertices), np.full(len(vertices), weight), PLACES[vertices])
    return result


def staying(others, vertices, weight):
    return others.staying_targets(np.asarray(vertices), np.full(len(vertices), weight), SHOWN[vertices])


def force(target, weight):
    return weight / (1.0 - weight) * (target - SHOWN[1])


def test_what_no_other_handle_holds_is_pulled_to_where_it_is():
    np.testing.assert_allclose(staying(pulls(), [0, 2], 1.0), SHOWN[[0, 2]])


@pytest.mark.parametrize(("former", "new"), [(0.3, 0.3), (0.3, 0.8), (0.8, 0.3)])
def test_soft_holds_together_pull_as_the_former_one(former, new):
    target = staying(pulls(([0, 1], former)), [1], new)[0]
    mean = (former * PLACES[1] + new * target) / (former + new)
    np.testing.assert_allclose(force(mean, max(former, new)), force(PLACES[1], former))


def test_a_hard_vertex_stays_where_it_is_whatever_a_soft_hold_wants():
    target = staying(pulls(([1], 0.3)), [1], 1.0)[0]
    np.testing.assert_allclose((0.3 * PLACES[1] + target) / 1.3, SHOWN[1])


def test_what_is_held_hard_stays_where_it_is_pulled_to():
    for weight in (1.0, 0.3):
        target = staying(pulls(([1], 1.0)), [1], weight)[0]
        np.testing.assert_allclose((PLACES[1] + weight * target) / (1.0 + weight), PLACES[1])


def test_handles_that_are_added_together_count_one_after_the_other():
    others = pulls(([1], 0.3))
    targets = []
    for _ in range(3):
        targets.append(staying(others, [1], 1.0)[0])
        others.add(np.array([1]), np.ones(1), targets[-1][None])
    np.testing.assert_allclose((0.3 * PLACES[1] + np.sum(targets, axis=0)) / 3.3, SHOWN[1])
