# SPDX-License-Identifier: GPL-3.0-or-later
"""Binds, constrains and solves every kind of bad mesh at growing sizes; says time and memory, and what went wrong.

    python tests/attack/measure_zoo.py [--model surface] [--kinds NAME ...] [--sizes 8000 64000 512000]
        [--limit-s 60] [--limit-gb 4]

Needs arap_native. Each mesh has a process of its own, which the limits end. Times are of the processor (user and
system), so other programs do not count. After a kind it says how many times as much time and memory a vertex and a face
take at the last size as at the first. Ends with 1 if a kind crashes, passes a limit, has a position that is not
finite, or an error without a cause in words.
"""

from __future__ import annotations

import argparse
import json
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

try:
    import resource
except ImportError:
    resource = None  # Windows limits and counts memory in other ways

sys.path.insert(0, str(Path(__file__).resolve().parent))

import zoo

# By the clock a mesh may take this many times its limit: other programs have their turns.
HANGS = 30
# Of the mesh's size, at rest. A sliver that is held at one corner turns freely about it: single precision leaves its
# angle open by some 1e-6. A lattice has far more unknowns than these meshes have vertices: crumpled 120,000 for 64. So
# few held vertices leave it soft as a whole, and single precision shows up to 5e-5.
DRIFT = {"surface": 3e-6, "lattice": 5e-4, "poisson": 1e-9, "embedded": 1e-6}
# The classes of arap_native, and of their options.
MODELS = {
    "surface": ("SurfaceArap", "Options"),
    "lattice": ("LatticeArap", "LatticeOptions"),
    "poisson": ("PoissonEditing", "PoissonOptions"),
    "embedded": ("EmbeddedDeformation", "EmbeddedOptions"),
}
PARTS = ("bind", "set", "solve")
REFUSALS = ("ValueError", "RuntimeError", "MemoryError")
HEADER = f"{'kind':32}{'vertices':>9}{'faces':>9}{'bind':>8}{'set':>8}{'solve':>8}{'us/face':>9}{'MB':>7}  what"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", choices=MODELS, default="surface")
    parser.add_argument("--kinds", nargs="+", choices=zoo.KINDS, default=list(zoo.KINDS), metavar="NAME")
    parser.add_argument("--sizes", nargs="+", type=int, default=[8000, 64000, 512000], help="vertices, about")
    parser.add_argument("--limit-s", type=float, default=60.0, help="seconds of the processor for one mesh")
    parser.add_argument("--limit-gb", type=float, default=4.0, help="memory for one mesh, 1e9 bytes")
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.one:
        if resource:
            ends_at = int(time.process_time() + args.limit_s) + 1
            resource.setrlimit(resource.RLIMIT_CPU, (ends_at, ends_at + 1))
        print(json.dumps(attack(args.model, args.kinds[0], args.sizes[0], args.threads)))
        return 0
    print(HEADER, flush=True)
    bad = 0
    for name in args.kinds:
        rows = []
        for size in args.sizes:
            rows.append(in_a_process(name, size, args))
            bad += rows[-1]["is_bad"]
            print(line(rows[-1]), flush=True)
        for text in growth(rows):
            print(text, flush=True)
    print(f"{len(args.kinds)} kinds, {bad} bad")
    return 1 if bad else 0


def in_a_process(name: str, size: int, args: argparse.Namespace) -> dict[str, Any]:
    command = [sys.executable, __file__, "--one", "--kinds", name, "--sizes", str(size)]
    command += ["--model", args.model, "--threads", str(args.threads), "--limit-s", str(args.limit_s)]
    limit = int(args.limit_gb * 1e9)
    row: dict[str, Any] = {"kind": name, "vertices": size, "is_bad": True}
    try:
        run = subprocess.run(
            command, capture_output=True, text=True, timeout=HANGS * args.limit_s, check=False,
            preexec_fn=(lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit))) if resource else None,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return row | {"what": f"not done after {HANGS * args.limit_s:g} s by the clock"}
    if resource and run.returncode == -signal.SIGXCPU:
        return row | {"what": f"not done after {args.limit_s:g} s"}
    if run.returncode:
        last = run.stderr.strip().splitlines()[-1:] or ["no message"]
        return row | {"what": f"ended with {run.returncode}: {last[0][:90]}"}
    return row | json.loads(run.stdout)


def line(row: dict[str, Any]) -> str:
    def number(name: str, form: str) -> str:
        return format(row[name], form) if name in row else "-"

    seconds = "".join(f"{number(part, '.2f'):>8}" for part in PARTS)
    counts = f"{row['vertices']:9}{number('faces', 'd'):>9}"
    per_face = f"{1e6 * seconds_of(row) / row['faces']:9.2f}" if row.get("faces") else f"{'-':>9}"
    return f"{row['kind']:32}{counts}{seconds}{per_face}{number('mb', '.0f'):>7}  {row['what']}"


def seconds_of(row: dict[str, Any]) -> float:
    return sum(row.get(part, 0.0) for part in PARTS)


def growth(rows: list[dict[str, Any]]) -> Iterator[str]:
    """Yields a line if two sizes or more were solved."""
    solved = [row for row in rows if all(part in row for part in PARTS)]
    if len(solved) > 1:
        first, last = solved[0], solved[-1]
        more = (last["vertices"] + last["faces"]) / (first["vertices"] + first["faces"])
        seconds, memory = seconds_of(last) / seconds_of(first) / more, last["mb"] / first["mb"] / more
        yield f"{'':32}  for each vertex and face: time x{seconds:.2f}, memory x{memory:.2f}"


def attack(model: str, name: str, size: int, threads: int) -> dict[str, Any]:
    """What happens to one mesh: bind, constraints on a hundredth of the vertices, a pull, and a solve at rest."""
    import arap_native

    mesh = zoo.KINDS[name](size, np.random.default_rng(0))
    row: dict[str, Any] = {"vertices": len(mesh.positions), "faces": len(mesh.sizes), "is_bad": False}
    before = resident_mb()
    clock = time.process_time()

    def lap(part: str) -> None:
        nonlocal clock
        now = time.process_time()
        row[part] = now - clock
        clock = now

    try:
        model_type, options_type = (getattr(arap_native, of_model) for of_model in MODELS[model])
        solver = model_type(*mesh, options=options_type(threads=threads))
        lap("bind")
        held = np.unique(np.linspace(0, len(mesh.positions) - 1, max(3, len(mesh.positions) // 100)).astype(np.int32))
        solver.set_constraints(held, np.ones(len(held)))
        lap("set")
        targets = mesh.positions[held]
        size_of_mesh = float(np.linalg.norm(np.ptp(mesh.positions, axis=0))) or 1.0
        targets[-1] += 0.3 * size_of_mesh
        pulled = solver.solve(targets, arap_native.SolveOptions(max_iterations=20))
        lap("solve")
        solver.reset()
        rested = solver.solve(mesh.positions[held], arap_native.SolveOptions(max_iterations=20))
    except Exception as error:  # noqa: BLE001 - what it is and says is the result
        refusal = f"{type(error).__name__}: {error}"
        is_told = type(error).__name__ in REFUSALS and str(error) and "std::" not in str(error)
        return row | {"what": refusal[:120], "is_bad": not is_told, "mb": resident_mb() - before}
    drift = float(np.abs(rested.positions - mesh.positions).max()) / size_of_mesh
    problems = []
    if not np.isfinite(pulled.positions).all():
        problems.append("not finite")
    if not drift < DRIFT[model]:
        problems.append(f"moves {drift:.1e} of its size at rest")
    return row | {"what": ", ".join(problems) or "ok", "is_bad": bool(problems), "mb": resident_mb() - before}


def resident_mb() -> float:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3 if resource else 0.0


if __name__ == "__main__":
    sys.exit(main())
