# SPDX-License-Identifier: GPL-3.0-or-later
"""From single timed runs to figures: medians, time of one iteration, time to near the minimum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import median
from typing import NamedTuple


class Run(NamedTuple):
    """A solve of so many iterations from rest: its time without the bind, and where it ended."""

    iterations: int
    ms: float
    energy: float


Solve = Callable[[int], Run]

MOST_ITERATIONS, MOST_SAMPLES = 40, 41
ENOUGH_MS = 150.0  # much more than the clock's and the scheduler's grain


class Cost(NamedTuple):
    """Milliseconds of one iteration, and what a solve costs once, whatever the iterations."""

    iteration_ms: float
    once_ms: float


def solve_cost(time_ms: Callable[[int], float], n_samples: int = 7) -> Cost:
    """Medians of what solves cost, of at least ``n_samples``; ``time_ms`` times a run of so many iterations from rest.

    Each sample is the difference between a run of 2 m iterations and one of m, so that what a solve costs once is told
    apart. m is chosen so that m iterations take about ENOUGH_MS, but never so many that the end of a descent
    is timed, where iterations may cost something else; fast ones are sampled more often instead.
    """
    first, twice = time_ms(4), time_ms(8)
    one = max((twice - first) / 4.0, twice / 64.0, 1e-4)
    m = max(3, min(MOST_ITERATIONS, round(ENOUGH_MS / one)))
    n = max(n_samples, min(MOST_SAMPLES, round(n_samples * ENOUGH_MS / (m * one))))
    runs = [(time_ms(m), time_ms(2 * m)) for _ in range(n)]
    return Cost(median([(b - a) / m for a, b in runs]), max(0.0, median([2 * a - b for a, b in runs])))


@dataclass
class Descent:
    """How the energy falls with the iterations.

    Attributes:
        runs: in the order of their iterations.
        is_converged: doubling the iterations last changed the energy by less than SETTLED.
    """

    runs: list[Run] = field(default_factory=list)
    is_converged: bool = False

    @property
    def minimum(self) -> float:
        return min(run.energy for run in self.runs)


SETTLED = 1e-3
FIRST_RUN, LONGEST_RUN = 4, 1 << 16  # iterations
NEAR_RESOLUTION = 1.03  # of the number of iterations


def descend(solve: Solve, budget_s: float) -> Descent:
    """Doubles the iterations until the energy settles, or until the next run would exceed the budget."""
    descent = Descent()
    spent_ms = 0.0
    n = FIRST_RUN
    while n <= LONGEST_RUN:
        run = solve(n)
        descent.runs.append(run)
        spent_ms += run.ms
        if len(descent.runs) > 1 and abs(descent.runs[-2].energy - run.energy) <= SETTLED * run.energy:
            descent.is_converged = True
            break
        if spent_ms + 2 * run.ms > 1e3 * budget_s:
            break
        n *= 2
    return descent


def reach(solve: Solve, descent: Descent, level: float, n_repeats: int = 3) -> Run | None:
    """The shortest run whose energy is at most ``level``, its time the median of some; None where none is.

    The runs that narrow it down are added to the descent.
    """
    reached = [run for run in descent.runs if run.energy <= level]
    if not reached:
        return None
    best = min(reached, key=lambda run: run.iterations)
    above = max((run.iterations for run in descent.runs if run.iterations < best.iterations), default=0)
    while best.iterations > above + 1 and best.iterations > NEAR_RESOLUTION * above:
        run = solve((best.iterations + above) // 2)
        descent.runs.append(run)
        if run.energy <= level:
            best = run
        else:
            above = run.iterations
    descent.runs.sort()
    times = [solve(best.iterations).ms for _ in range(n_repeats - 1)]
    return best._replace(ms=median([best.ms, *times]))
