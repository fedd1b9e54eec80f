# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of a student's report on as-rigid-as-possible deformation, measured anew on its meshes.

    python -m measure.runs.report OUT.json

The report: 200 iterations of [SA07] with and without OpenMP; linear solvers; energies of small, medium and large moves;
with and without the naive Laplacian as initial guess. Its figures are in published.py. The meshes are taken from
ARAP_BENCH_MESHES by their file names; those that are not there are in the result as not run.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path
from statistics import median
from typing import Any

from ..base import machine
from ..base.installed import own_program
from ..base.workers import NotRun, Worker
from ..inputs.mesh import Mesh, named_meshes
from ..inputs.tasks import displacement, write_task
from .peers import Energy, Files, Yardstick, worker_command
from .published import ENERGY_MESHES, GUESSES, MOVES, PUBLISHED_S, SOLVER_MESHES

ITERATIONS = 200
ENERGY: Energy = "spokes"
TIMEOUT_S = 300.0
SOLVERS = ("block_ldlt", "simplicial_ldlt", "sparse_lu", "sparse_qr", "bicgstab")


class Case:
    """A mesh with one move."""

    def __init__(self, mesh: Mesh, share: float, folder: Path) -> None:
        self.files = Files(folder / f"task-{share:g}.bin", folder / "positions.bin")
        write_task(self.files.task, mesh, displacement(mesh, share))
        self._yardstick = Yardstick(mesh)

    def run(self, threads: int = 0, initial_guess: str = "previous", **options: object) -> dict[str, Any]:
        """Seconds of bind and 200 iterations, and the energy reached; or why it was not run."""
        given = {"energy": ENERGY, "threads": threads, "initial_guess": initial_guess, **options}
        command = worker_command(sys.executable, "ours", self.files, **given)
        try:
            with Worker(command, timeout_s=TIMEOUT_S) as worker:
                bind_ms = worker.ask("bind")["ms"]
                solve_ms = median([worker.ask(f"solve {ITERATIONS}")["ms"] for _ in range(3)])
        except NotRun as reason:
            return {"not_run": str(reason)}
        energy = self._yardstick.energy(self.files.positions, ENERGY)
        return {"bind_s": 1e-3 * bind_ms, "total_s": 1e-3 * (bind_ms + solve_ms), "energy": energy}

    def run_solver(self, solver: str) -> dict[str, Any]:
        """The same with a sparse solver, which only the program in C++ can choose."""
        try:
            command = [own_program(), self.files.task, ENERGY, "0", solver]
            with Worker(command, timeout_s=TIMEOUT_S) as worker:
                bind_ms = worker.ask("bind")["ms"] + worker.ask("constraints")["ms"]
                solves = [worker.ask(f"solve {ITERATIONS}") for _ in range(3)]
        except NotRun as reason:
            return {"not_run": str(reason)}
        solve_ms = median(solve["ms"] for solve in solves)
        return {"bind_s": 1e-3 * bind_ms, "total_s": 1e-3 * (bind_ms + solve_ms), "energy": solves[-1]["energy"]}


def measure(folder: Path) -> dict[str, Any]:
    meshes = {mesh.name: mesh for mesh in named_meshes()}
    cores = os.cpu_count() or 1
    tables: dict[str, list[dict[str, Any]]] = {"times": [], "solvers": [], "energies": [], "guesses": []}

    def say(table: str, row: dict[str, Any]) -> None:
        tables[table].append(row)
        print(f"{table}: {row}", file=sys.stderr, flush=True)

    for name in PUBLISHED_S:
        if name not in meshes:
            say("times", {"mesh": name, "not_run": "its file is not in ARAP_BENCH_MESHES"})
            continue
        mesh = meshes[name]
        about = {"mesh": name, "n_vertices": len(mesh.positions)}
        large = Case(mesh, MOVES["large"], folder)
        say("times", {**about, "one": large.run(1), "all": large.run(cores), "own": large.run(0)})
        say("guesses", {**about, **{guess: large.run(initial_guess=guess) for guess in GUESSES}})
        if name in SOLVER_MESHES:
            for solver in SOLVERS:
                say("solvers", {**about, "solver": solver, **large.run_solver(solver)})
        if name in ENERGY_MESHES:
            moves = {move: Case(mesh, share, folder).run() for move, share in MOVES.items()}
            say("energies", {**about, **moves})
    return {"cores": cores, **tables}


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="measure.runs.report", description="A student report's tables, measured anew."
    )
    parser.add_argument("out", type=Path, help="the JSON file to write")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=args.out.parent) as folder:
        result = {"machine": machine.description(), **measure(Path(folder))}
    args.out.write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
