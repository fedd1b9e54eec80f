# SPDX-License-Identifier: GPL-3.0-or-later
"""The library by itself, in C++: what each act costs, by size, instruction set and number of threads.

    python -m measure.runs.native PROGRAM OUT.json [--sizes N...] [--budget S]

PROGRAM is native/bench/worker.cpp, built. Meshes are the sample creature at the given sizes and what ARAP_BENCH_MESHES
names. The way to the minimum, and all about large meshes, whose binds on one slow thread would take minutes, is
measured with the fastest instruction set; the former with the library's own choice of threads.
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
from ..base.convergence import Run, descend, reach, solve_cost
from ..base.workers import NotRun, Worker
from ..inputs.mesh import Mesh, creature, named_meshes
from ..inputs.tasks import bend, write_task

ENERGIES = ("rotation_nodes", "spokes_and_rims", "spokes")
SIZES = (10_000, 100_000, 1_000_000)
LEVELS = (1.1, 1.01)
TIMEOUT_S = 1800.0
DRAM_BYTES = 1_000_000_000  # far more than caches hold
SLOW_MS = 2000.0  # what takes longer is measured twice
LARGE = 500_000  # vertices


class Program:
    """The program on one task file."""

    def __init__(self, path: Path, task: Path) -> None:
        self._path, self._task = path, task

    def start(self, energy: str, threads: int, isa: str) -> Worker:
        return Worker([self._path, self._task, energy, str(threads)], {"ARAP_ISA": isa} if isa else {}, TIMEOUT_S)

    def try_instruction_set(self, isa: str) -> None:
        with self.start("spokes", 1, isa) as worker:
            worker.ask("bind")


def repeated_ms(worker: Worker, command: str, n: int = 5) -> float:
    """Median time of a command; where it is slow, of the first two."""
    times = [float(worker.ask(command)["ms"])]
    while len(times) < (2 if times[0] > SLOW_MS else n):
        times.append(float(worker.ask(command)["ms"]))
    return median(times)


def measure_acts(program: Program, energy: str, threads: int, isa: str) -> dict[str, Any]:
    """What each act costs."""
    with program.start(energy, threads, isa) as worker:
        worker.ask("bind")
        worker.ask("constraints")
        worker.ask("solve 2")
        peak_mb = worker.ask("memory")["peak_mb"]
        row: dict[str, Any] = {
            "peak_mb": peak_mb,
            **solve_cost(lambda n: float(worker.ask(f"plain {n}")["ms"]))._asdict(),
            "refactor_ms": repeated_ms(worker, "constraints"),
            "bind_ms": repeated_ms(worker, "bind", 3),
            **worker.ask("steps"),
        }
        if row["factor_bytes"]:
            row["solve_gb_per_s"] = 2e-6 * row["factor_bytes"] / row["solve_ms"]
        row["read_gb_per_s"] = worker.ask(f"bandwidth {row['factor_bytes'] or DRAM_BYTES}")["gb_per_s"]
        return row


def dram_gb_per_s(program: Program) -> list[float]:
    """Rate at which memory is read by 1, 2, ... threads."""
    rates = []
    for threads in range(1, (os.cpu_count() or 1) + 1):
        with program.start("spokes", threads, "") as worker:
            rates.append(float(worker.ask(f"bandwidth {DRAM_BYTES}")["gb_per_s"]))
    return rates


def measure_descent(program: Program, energy: str, isa: str, budget_s: float) -> dict[str, Any]:
    """From rest to near the minimum, on as many threads as the library takes."""
    with program.start(energy, 0, isa) as worker:
        threads = worker.ask("bind")["threads"]

        def solve(n_iterations: int) -> Run:
            answer = worker.ask(f"solve {n_iterations}")
            return Run(n_iterations, answer["ms"], answer["energy"])

        descent = descend(solve, budget_s)
        near = {str(level): reach(solve, descent, level * descent.minimum) for level in LEVELS}
        return {
            "energy": energy,
            "isa": isa,
            "threads": threads,
            "minimum": descent.minimum,
            "is_converged": descent.is_converged,
            "near": {
                level: {"iterations": run.iterations, "ms": run.ms} if run else None for level, run in near.items()
            },
        }


def measure_mesh(path: Path, mesh: Mesh, folder: Path, budget_s: float) -> dict[str, Any]:
    task = folder / "task.bin"
    write_task(task, mesh, bend(mesh))
    program = Program(path, task)
    isas, not_run = machine.instruction_sets(program.try_instruction_set)
    rows: list[dict[str, Any]] = [{"isa": isa, "not_run": reason} for isa, reason in not_run.items()]
    for isa in isas if len(mesh.positions) < LARGE else isas[-1:]:
        for energy in ENERGIES:
            for threads in range(1, (os.cpu_count() or 1) + 1):
                row: dict[str, Any] = {"isa": isa, "energy": energy, "threads": threads}
                try:
                    row |= measure_acts(program, energy, threads, isa)
                except NotRun as reason:
                    row["not_run"] = str(reason)
                rows.append(row)
                shown = row.get("not_run") or f"{row['iteration_ms']:.3f} ms an iteration"
                print(f"{mesh.name}: {isa} {energy}, {threads} threads: {shown}", file=sys.stderr, flush=True)
    descents = [measure_descent(program, energy, isas[-1], budget_s) for energy in ENERGIES]
    return {
        "mesh": mesh.name,
        "n_vertices": len(mesh.positions),
        "dram_gb_per_s": dram_gb_per_s(program),
        "rows": rows,
        "descents": descents,
    }


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.runs.native", description="The library by itself.")
    parser.add_argument("program", type=Path)
    parser.add_argument("out", type=Path, help="the JSON file to write")
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES, help="vertices of the creature")
    parser.add_argument("--budget", type=float, default=60.0, help="seconds to the minimum")
    args = parser.parse_args()
    result: dict[str, Any] = {"machine": machine.description(), "meshes": []}
    with tempfile.TemporaryDirectory(dir=args.out.parent) as folder:
        for mesh in (*map(creature, args.sizes), *named_meshes()):
            result["meshes"].append(measure_mesh(args.program, mesh, Path(folder), args.budget))
            args.out.write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
