# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables of a student's report on as-rigid-as-possible deformation, measured anew on its meshes.

    python -m measure.report OUT.json [--timeout S]

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
from typing import Any

import arap_native

from . import machine
from .convergence import median
from .meshes import Mesh, load_off, mesh_files
from .peers import Files, Yardstick, worker_command
from .published import ENERGY_MESHES, GUESSES, MOVES, PUBLISHED_S, SOLVER_MESHES
from .tasks import displacement, write_task
from .workers import NotRun, Worker

ITERATIONS = 200
ENERGY = "spokes"
SOLVERS = ("block_ldlt", "simplicial_ldlt", "sparse_lu", "sparse_qr", "bicgstab")


class Case:
    """A mesh with one move."""

    def __init__(self, mesh: Mesh, share: float, folder: Path, timeout_s: float) -> None:
        self.files = Files(folder / f"task-{share:g}.bin", folder / "positions.bin")
        write_task(self.files.task, mesh, displacement(mesh, share))
        self._yardstick = Yardstick(mesh)
        self._timeout_s = timeout_s

    def run(self, threads: int = 0, initial_guess: str = "previous", **options: object) -> dict[str, Any]:
        """Seconds of bind and 200 iterations, and the energy reached; or why it was not run."""
        given: dict[str, object] = {"energy": ENERGY, "threads": threads, "initial_guess": initial_guess, **options}
        command = worker_command(sys.executable, "ours", self.files, given)
        try:
            with Worker(command, timeout_s=self._timeout_s) as worker:
                bind_ms = worker.ask("bind")["ms"]
                solve_ms = median([worker.ask(f"solve {ITERATIONS}")["ms"] for _ in range(3)])
        except NotRun as reason:
            return {"not_run": str(reason)}
        energy = self._yardstick.energy(self.files.positions, ENERGY)
        return {"bind_s": 1e-3 * bind_ms, "total_s": 1e-3 * (bind_ms + solve_ms), "energy": energy}


def linear_solvers() -> list[str | None]:
    """What arap_native lets one choose; [None] where it has no choice."""
    keyword: dict[str, Any] = {"linear_solver": SOLVERS[0]}
    try:
        arap_native.Options(**keyword)
    except TypeError:
        return [None]
    return list(SOLVERS)


def measure(folder: Path, timeout_s: float) -> dict[str, Any]:
    files = {path.stem: path for path in mesh_files(os.environ.get("ARAP_BENCH_MESHES", ""))}
    cores = os.cpu_count() or 1
    tables: dict[str, list[dict[str, Any]]] = {"times": [], "solvers": [], "energies": [], "guesses": []}

    def say(table: str, row: dict[str, Any]) -> None:
        tables[table].append(row)
        print(f"{table}: {row}", file=sys.stderr, flush=True)

    for name in PUBLISHED_S:
        if name not in files:
            say("times", {"mesh": name, "not_run": "its file is not in ARAP_BENCH_MESHES"})
            continue
        mesh = load_off(files[name])
        about = {"mesh": name, "n_vertices": len(mesh.positions)}
        large = Case(mesh, MOVES["large"], folder, timeout_s)
        say("times", {**about, "one": large.run(1), "all": large.run(cores), "own": large.run(0)})
        say("guesses", {**about, **{guess: large.run(initial_guess=guess) for guess in GUESSES}})
        if name in SOLVER_MESHES:
            for solver in linear_solvers():
                options: dict[str, Any] = {"linear_solver": solver} if solver else {}
                say("solvers", {**about, "solver": solver, **large.run(**options)})
        if name in ENERGY_MESHES:
            moves = {move: Case(mesh, share, folder, timeout_s).run() for move, share in MOVES.items()}
            say("energies", {**about, **moves})
    return {"cores": cores, **tables}


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.report", description="A student report's tables, measured anew.")
    parser.add_argument("out", type=Path, help="the JSON file to write")
    parser.add_argument("--timeout", type=float, default=300.0, help="seconds after which a command counts as not run")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=args.out.parent) as folder:
        result = {"machine": machine.description(), **measure(Path(folder), args.timeout)}
    args.out.write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
