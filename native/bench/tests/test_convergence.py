# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures that the benchmarks make of single runs."""

import pytest
from measure.base.convergence import NEAR_RESOLUTION, Descent, Run, descend, reach, solve_cost


class Falling:
    """A library whose energy is 1 + 1/k^2 after k iterations, one millisecond each; counts its runs."""

    def __init__(self) -> None:
        self.asked: list[int] = []

    def __call__(self, iterations: int) -> Run:
        self.asked.append(iterations)
        return Run(iterations, float(iterations), 1.0 + iterations**-2.0)


@pytest.mark.parametrize("once_ms", [0.0, 500.0])
def test_iterations_and_what_a_solve_costs_once_are_told_apart(once_ms):
    cost = solve_cost(lambda n: once_ms + 0.25 * n)
    assert cost.iteration_ms == pytest.approx(0.25)
    assert cost.once_ms == pytest.approx(once_ms, abs=1e-9)


def test_iteration_time_of_a_slow_library_takes_few_iterations():
    asked = []
    assert solve_cost(lambda n: asked.append(n) or 1000.0 * n).iteration_ms == pytest.approx(1000.0)
    assert max(asked) <= 8


def test_iterations_are_timed_while_the_energy_still_falls():
    asked = []
    solve_cost(lambda n: asked.append(n) or 1e-3 * n)
    assert max(asked) <= 80
    assert len(asked) > 2 * 7  # fast ones are sampled more often instead


def test_a_descent_doubles_until_the_energy_settles():
    solve = Falling()
    descent = descend(solve, budget_s=1e9)
    assert descent.is_converged
    assert solve.asked == [4 * 2**k for k in range(len(solve.asked))]
    assert descent.minimum == descent.runs[-1].energy
    assert descent.runs[-2].energy - descent.minimum <= 1e-3 * descent.minimum


def test_a_descent_ends_before_its_budget_does():
    descent = descend(Falling(), budget_s=0.040)
    assert not descent.is_converged
    assert sum(run.ms for run in descent.runs) <= 40.0


def test_an_energy_that_rises_has_not_settled():
    descent = descend(lambda n: Run(n, 1.0, float(n)), budget_s=1.0)
    assert not descent.is_converged
    assert descent.minimum == 4.0


@pytest.mark.parametrize("level", [1.05, 1.01, 1.001])
def test_reach_finds_the_shortest_run_below_a_level(level):
    solve = Falling()
    descent = descend(solve, budget_s=1e9)
    exact = (level - 1.0) ** -0.5
    run = reach(solve, descent, level)
    assert run.energy <= level
    assert exact <= run.iterations <= NEAR_RESOLUTION * exact + 1
    assert descent.runs == sorted(descent.runs)


def test_reach_finds_nothing_below_the_lowest_energy():
    solve = Falling()
    assert reach(solve, descend(solve, budget_s=1e9), 1.0) is None


def test_reach_takes_the_median_time_of_its_repeats():
    times = iter([9.0, 5.0])
    descent = Descent([Run(1, 7.0, 1.0)], is_converged=True)
    assert reach(lambda n: Run(n, next(times), 1.0), descent, 1.0).ms == 7.0
