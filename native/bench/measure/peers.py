# SPDX-License-Identifier: GPL-3.0-or-later
"""Ours and other libraries on the same meshes and the same task, in one run.

    python -m measure.peers OUT.json [--subdivide N] [--rounds R] [--budget S] [--threads T]

Meshes are the sample creature at 12k vertices and what ARAP_BENCH_MESHES names; with --subdivide also the first N
midpoint subdivisions of those. Each library runs in a process of its own; what cannot run is in the result with the
reason. The bind and the iterations are timed in rounds, all libraries one after the other in each, so that a busy
moment of the machine does not fall on one of them alone.
"""

from __future__ import annotations

import argparse
import functools
import json
import os
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np
from arap_native import Options, SurfaceArap

from . import machine
from .convergence import Run, descend, median, reach, solve_cost
from .installed import ROOT, cgal_program, library_python
from .meshes import Mesh, creature, load_off, mesh_files, midpoint_subdivision, triangulated
from .tasks import Task, bend, write_task
from .workers import NotRun, Worker

Energy = Literal["rotation_nodes", "spokes_and_rims", "spokes"]

CREATURE_VERTICES = 12_000
ENERGIES: tuple[Energy, ...] = ("spokes", "spokes_and_rims")  # that others have too
OUR_ENERGIES: tuple[Energy, ...] = ("rotation_nodes", *ENERGIES)
NEAR = 1.01
N_BINDS, N_SAMPLES = 3, 3


class Contender(NamedTuple):
    """A library, ours once for each instruction set, with one energy."""

    library: str
    energy: str
    isa: str
    command: list[str]
    plain_command: list[str]  # for the times of iterations: local/global without acceleration
    env: dict[str, str]

    @property
    def name(self) -> str:
        return f"{self.library} {self.isa} {self.energy}".replace("  ", " ")


class Yardstick:
    """Energies of any positions of a mesh, by our definition of both."""

    def __init__(self, mesh: Mesh) -> None:
        self._models = {str(energy): SurfaceArap(*mesh[1:], Options(energy=energy)) for energy in OUR_ENERGIES}

    def energies(self, path: Path) -> dict[str, float]:
        positions = np.fromfile(path, "<f8").reshape(-1, 3)
        return {energy: model.energy(positions) for energy, model in self._models.items()}

    def energy(self, path: Path, energy: str) -> float:
        return self._models[energy].energy(np.fromfile(path, "<f8").reshape(-1, 3))


class Files(NamedTuple):
    task: Path
    positions: Path


def worker_command(python: str | Path, library: str, files: Files, options: dict[str, object]) -> list[str]:
    return [str(python), "-m", "peers.worker", library, str(files.task), str(files.positions), json.dumps(options)]


def contenders(files: Files, threads: int) -> tuple[list[Contender], list[dict[str, Any]]]:
    """Who takes part, ours first, and rows for those that cannot."""
    env = {"OMP_NUM_THREADS": str(threads), "IGL_NUM_THREADS": str(threads)}
    found: list[Contender] = []
    missing: list[dict[str, Any]] = []

    def add(library: str, energies: Sequence[str], set_up: Callable[[], Callable[[str], list[str]]]) -> None:
        try:
            command = set_up()
        except NotRun as reason:
            missing.append({"library": library, "not_run": str(reason)})
        else:
            found.extend(Contender(library, energy, "", command(energy), command(energy), env) for energy in energies)

    def with_python(library: str, *groups: str) -> Callable[[str], list[str]]:
        python = _python_of(library, *groups)
        return lambda energy: worker_command(python, library, files, {"energy": energy})

    def with_cgal() -> Callable[[str], list[str]]:
        program = _cgal()
        return lambda energy: [str(program), str(files.task), energy, str(files.positions)]

    isas, not_run = our_instruction_sets(files)
    for isa in reversed(isas):
        for energy in OUR_ENERGIES:
            options: dict[str, object] = {"energy": energy, "threads": threads}
            command, plain = (
                worker_command(sys.executable, "ours", files, {**options, "acceleration": acceleration})
                for acceleration in ("conjugate_gradients", "none")
            )
            found.append(Contender("ours", energy, isa, command, plain, env | ({"ARAP_ISA": isa} if isa else {})))
    missing += [{"library": "ours", "isa": isa, "not_run": reason} for isa, reason in not_run.items()]
    add("libigl", ENERGIES, lambda: with_python("libigl"))
    add("open3d", ("spokes",), lambda: with_python("open3d", "peers"))
    add("cgal", ENERGIES, with_cgal)
    return found, missing


_python_of = functools.cache(library_python)
_cgal = functools.cache(cgal_program)


def our_instruction_sets(files: Files) -> tuple[list[str], dict[str, str]]:
    def bind(isa: str) -> None:
        command = worker_command(sys.executable, "ours", files, {"energy": "spokes", "threads": 1})
        with Worker(command, {"ARAP_ISA": isa}) as worker:
            worker.ask("bind")

    return machine.instruction_sets(bind)


def time_once(contender: Contender, timeout_s: float) -> dict[str, Any]:
    """Bind and iteration times, cores used and memory, in a new process."""
    cores_used: list[float] = []
    with Worker(contender.plain_command, contender.env, timeout_s) as worker:

        def solve_ms(n_iterations: int) -> float:
            answer = worker.ask(f"solve {n_iterations}")
            cores_used.append(answer["cores"])
            return float(answer["ms"])

        version = worker.ask("version")["version"]
        before_mb = worker.ask("memory")["peak_mb"]
        bind_ms = [worker.ask("bind")["ms"]]
        solve_ms(4)
        peak_mb = worker.ask("memory")["peak_mb"]
        bind_ms += [worker.ask("bind")["ms"] for _ in range(N_BINDS - 1)]
        return {
            "version": version,
            "bind_ms": median(bind_ms),
            **solve_cost(solve_ms, N_SAMPLES)._asdict(),
            "cores_used": median(cores_used),
            "before_mb": before_mb,
            "peak_mb": peak_mb,
        }


def converge(
    contender: Contender, files: Files, yardstick: Yardstick, budget_s: float, lowest: float
) -> dict[str, Any]:
    """From rest to the own minimum; where the budget ends before, the lowest known counts as the minimum."""
    with Worker(contender.command, contender.env, max(600.0, 20 * budget_s)) as worker:
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
    task: Task = bend(mesh)
    files = Files(folder / "task.bin", folder / "positions.bin")
    write_task(files.task, mesh, task)
    found, rows = contenders(files, args.threads)
    timings: dict[str, list[dict[str, Any]]] = {contender.name: [] for contender in found}
    failed: dict[str, str] = {}
    for _ in range(args.rounds):
        for contender in found:
            if contender.name in failed:
                continue
            try:
                timings[contender.name].append(time_once(contender, args.timeout))
            except NotRun as reason:
                failed[contender.name] = str(reason)
    yardstick = Yardstick(mesh)
    lowest = dict.fromkeys(map(str, OUR_ENERGIES), np.inf)
    for contender in found:
        row: dict[str, Any] = {"library": contender.library, "energy": contender.energy, "isa": contender.isa}
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
        say(f"{mesh.name}: {contender.name}: {row.get('not_run') or round(row['iteration_ms'], 3)}")
    return {"mesh": mesh.name, "n_vertices": len(mesh.positions), "rows": rows}


def summary(rounds: list[dict[str, Any]]) -> dict[str, Any]:
    """Medians over the rounds, and each round's time of an iteration for ratios within one round."""
    result = {key: median([r[key] for r in rounds]) for key in rounds[0] if key != "version"}
    return {**result, "version": rounds[0]["version"], "iteration_ms_of_rounds": [r["iteration_ms"] for r in rounds]}


def meshes(subdivide: int) -> list[Mesh]:
    result = [triangulated(creature(CREATURE_VERTICES))]
    for path in mesh_files(os.environ.get("ARAP_BENCH_MESHES", "")):
        finer = [triangulated(load_off(path))]
        for _ in range(subdivide):
            finer.append(midpoint_subdivision(finer[-1]))
        result += finer
    return result


def say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.peers", description="Ours and other libraries in one run.")
    parser.add_argument("out", type=Path, help="the JSON file to write")
    parser.add_argument("--subdivide", type=int, default=0, help="midpoint subdivisions of the named meshes")
    parser.add_argument("--rounds", type=int, default=3, help="rounds of timing")
    parser.add_argument("--budget", type=float, default=60.0, help="seconds a library may take to its minimum")
    parser.add_argument("--timeout", type=float, default=600.0, help="seconds after which a command counts as not run")
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
