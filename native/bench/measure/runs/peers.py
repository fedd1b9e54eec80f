# SPDX-License-Identifier: GPL-3.0-or-later
"""Ours and other libraries on the same meshes and the same task, in one run.

    python -m measure.runs.peers OUT.json [--subdivide N] [--rounds R] [--budget S] [--threads T]

Meshes are the sample creature at 12k vertices and what ARAP_BENCH_MESHES names; with --subdivide also the first N
midpoint subdivisions of those. Each library runs in a process of its own; what cannot run is in the result with the
reason. The bind and the iterations are timed in rounds, all libraries one after the other in each, so that a busy
moment of the machine does not fall on one of them alone.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from pathlib import Path
from statistics import median
from typing import Any, Literal, NamedTuple

import numpy as np
from arap_native import Options, SurfaceArap

from ..base import machine
from ..base.convergence import Run, descend, reach, solve_cost
from ..base.installed import ROOT, cgal_program, library_python
from ..base.workers import NotRun, Worker
from ..inputs.mesh import Mesh, creature, midpoint_subdivision, named_meshes, triangulated
from ..inputs.tasks import bend, write_task

Energy = Literal["rotation_nodes", "spokes_and_rims", "spokes"]

CREATURE_VERTICES = 12_000
OUR_ENERGIES: tuple[Energy, ...] = ("rotation_nodes", "spokes", "spokes_and_rims")
PEERS: dict[str, tuple[Energy, ...]] = {"libigl": OUR_ENERGIES[1:], "open3d": ("spokes",), "cgal": OUR_ENERGIES[1:]}
NEAR = 1.01
N_BINDS, N_SAMPLES = 3, 3
TIMEOUT_S = 600.0


class Contender(NamedTuple):
    """A library with one energy."""

    library: str
    energy: Energy
    command: list[str]
    plain_command: list[str]  # for the times of iterations: local/global without acceleration
    env: dict[str, str]

    @property
    def name(self) -> str:
        return f"{self.library} {self.energy}"


class Yardstick:
    """Energies of any positions of a mesh, by our definition of each."""

    def __init__(self, mesh: Mesh) -> None:
        self._models = {energy: SurfaceArap(*mesh[1:], options=Options(energy=energy)) for energy in OUR_ENERGIES}

    def energies(self, path: Path) -> dict[str, float]:
        return {energy: self.energy(path, energy) for energy in OUR_ENERGIES}

    def energy(self, path: Path, energy: Energy) -> float:
        return self._models[energy].energy(np.fromfile(path, "<f8").reshape(-1, 3))


class Files(NamedTuple):
    task: Path
    positions: Path


def worker_command(python: str | Path, library: str, files: Files, **options: object) -> list[str]:
    return [str(python), "-m", "peers.worker", library, str(files.task), str(files.positions), json.dumps(options)]


def contenders(files: Files, threads: int) -> tuple[list[Contender], list[dict[str, Any]]]:
    """Who takes part, ours first, and rows for those that cannot."""
    env = {"OMP_NUM_THREADS": str(threads), "IGL_NUM_THREADS": str(threads)}
    found: list[Contender] = []
    missing: list[dict[str, Any]] = []

    def ours(energy: Energy, **options: object) -> list[str]:
        return worker_command(sys.executable, "ours", files, energy=energy, **options)

    for energy in OUR_ENERGIES:
        command, plain = (
            ours(energy, threads=threads, acceleration=acceleration) for acceleration in ("conjugate_gradients", "none")
        )
        found.append(Contender("ours", energy, command, plain, env))

    def theirs(library: str, energy: Energy) -> list[str]:
        if library == "cgal":
            return [str(cgal_program()), str(files.task), energy, str(files.positions)]
        groups = ["peers"] if library == "open3d" else []
        return worker_command(library_python(library, *groups), library, files, energy=energy)

    for library, energies in PEERS.items():
        try:
            for energy in energies:
                command = theirs(library, energy)
                found.append(Contender(library, energy, command, command, env))
        except NotRun as reason:
            missing.append({"library": library, "not_run": str(reason)})
    return found, missing


def time_once(contender: Contender) -> dict[str, Any]:
    """Bind and iteration times and memory, in a new process."""
    with Worker(contender.plain_command, contender.env, TIMEOUT_S) as worker:

        def solve_ms(n_iterations: int) -> float:
            return float(worker.ask(f"solve {n_iterations}")["ms"])

        version = worker.ask("version")["version"]
        bind_ms = [worker.ask("bind")["ms"]]
        solve_ms(4)
        peak_mb = worker.ask("memory")["peak_mb"]
        bind_ms += [worker.ask("bind")["ms"] for _ in range(N_BINDS - 1)]
        return {
            "version": version,
            "bind_ms": median(bind_ms),
            **solve_cost(solve_ms, N_SAMPLES)._asdict(),
            "peak_mb": peak_mb,
        }


def converge(
    contender: Contender, files: Files, yardstick: Yardstick, budget_s: float, lowest: float
) -> dict[str, Any]:
    """From rest to the own minimum; where the budget ends before, the lowest known counts as the minimum."""
    with Worker(contender.command, contender.env, max(TIMEOUT_S, 20 * budget_s)) as worker:
        worker.ask("bind")

        def solve(n_iterations: int) -> Run:
            answer = worker.ask(f"solve {n_iterations}")
            return Run(n_iterations, answer["ms"], yardstick.energy(files.positions, contender.energy))

        descent = descend(solve, budget_s)
        energies = yardstick.energies(files.positions)
        minimum = descent.minimum if descent.is_converged else min(descent.minimum, lowest)
        near = reach(solve, descent, NEAR * minimum)
    return {
        "runs": [list(run) for run in descent.runs],
        "is_converged": descent.is_converged,
        "minimum": minimum,
        "energies": energies,
        "near": {"iterations": near.iterations, "ms": near.ms} if near else None,
    }


def measure_mesh(mesh: Mesh, args: argparse.Namespace, folder: Path) -> dict[str, Any]:
    files = Files(folder / "task.bin", folder / "positions.bin")
    write_task(files.task, mesh, bend(mesh))
    found, rows = contenders(files, args.threads)
    timings: dict[str, list[dict[str, Any]]] = {contender.name: [] for contender in found}
    failed: dict[str, str] = {}
    for _ in range(args.rounds):
        for contender in found:
            if contender.name in failed:
                continue
            try:
                timings[contender.name].append(time_once(contender))
            except NotRun as reason:
                failed[contender.name] = str(reason)
    yardstick = Yardstick(mesh)
    lowest = dict.fromkeys(OUR_ENERGIES, np.inf)
    for contender in found:
        row: dict[str, Any] = {"library": contender.library, "energy": contender.energy}
        rows.append(row)
        if contender.name not in failed:
            row |= summary(timings[contender.name])
            try:
                row |= converge(contender, files, yardstick, args.budget, lowest[contender.energy])
                lowest[contender.energy] = min(lowest[contender.energy], row["minimum"])
            except NotRun as reason:
                failed[contender.name] = str(reason)
        if contender.name in failed:
            row["not_run"] = failed[contender.name]
        shown = row.get("not_run") or round(row["iteration_ms"], 3)
        print(f"{mesh.name}: {contender.name}: {shown}", file=sys.stderr, flush=True)
    return {"mesh": mesh.name, "n_vertices": len(mesh.positions), "rows": rows}


def summary(rounds: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians over the rounds, and each round's time of an iteration for ratios within one round."""
    result = {key: median([r[key] for r in rounds]) for key in rounds[0] if key != "version"}
    return {**result, "version": rounds[0]["version"], "iteration_ms_of_rounds": [r["iteration_ms"] for r in rounds]}


def meshes(subdivide: int) -> list[Mesh]:
    result = [triangulated(creature(CREATURE_VERTICES))]
    for mesh in named_meshes():
        finer = [triangulated(mesh)]
        for _ in range(subdivide):
            finer.append(midpoint_subdivision(finer[-1]))
        result += finer
    return result


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.runs.peers", description="Ours and other libraries in one run.")
    parser.add_argument("out", type=Path, help="the JSON file to write")
    parser.add_argument("--subdivide", type=int, default=0, help="midpoint subdivisions of the named meshes")
    parser.add_argument("--rounds", type=int, default=3, help="rounds of timing")
    parser.add_argument("--budget", type=float, default=60.0, help="seconds a library may take to its minimum")
    parser.add_argument("--threads", type=int, default=2, help="threads of each library that can use them")
    args = parser.parse_args()
    result: dict[str, Any] = {"machine": machine.description(), "threads": args.threads, "meshes": []}
    result["budget_s"] = args.budget
    with tempfile.TemporaryDirectory(dir=ROOT / "build") as folder:
        for mesh in meshes(args.subdivide):
            result["meshes"].append(measure_mesh(mesh, args, Path(folder)))
            args.out.write_text(json.dumps(result, indent=1))


if __name__ == "__main__":
    main()
