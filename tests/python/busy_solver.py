# SPDX-License-Identifier: GPL-3.0-or-later
"""Solvers that are kept busy, and everything that is refused meanwhile."""

from collections.abc import Callable

import arap_native
import numpy as np
from sample_meshes import Mesh, ends, twisted_ends

ENDLESS = {"max_iterations": 10**9, "accuracy": 0.0}
HANG_LIMIT_S = 600
BUSY = (
    "this SurfaceArap is at work in a job, in another thread or below its own progress callback: wait until that has "
    "ended, or use one SurfaceArap per thread"
)


def held_at_ends(mesh: Mesh) -> arap_native.SurfaceArap:
    solver = arap_native.SurfaceArap(*mesh)
    vertices = ends(mesh)
    solver.set_constraints(vertices, np.ones(len(vertices)))
    return solver


def uses(mesh: Mesh, solver: arap_native.SurfaceArap) -> list[Callable]:
    return [
        lambda: solver.solve(twisted_ends(mesh)),
        lambda: solver.set_constraints(ends(mesh), np.ones(len(ends(mesh)))),
        lambda: solver.set_positions(mesh.positions),
        lambda: solver.energy(mesh.positions),
        lambda: solver.energy_gradient(mesh.positions),
        lambda: solver.positions,
        lambda: solver.n_factorizations,
        solver.reset,
    ]
