# SPDX-License-Identifier: GPL-3.0-or-later
"""What a solid costs on meshes of several sizes: seconds of a bind and of a frame, and memory, each in its process.

    python -m measure.runs.cost VERTICES MODEL CUBE_SIZE

waits for a line, then prints a line of JSON.
"""

from __future__ import annotations

import gc
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

import arap_native
import numpy as np
from numpy.typing import NDArray

from ..base.machine import process_memory
from ..base.workers import NotRun, Worker
from ..inputs.mesh import Floats, Mesh, creature
from ..inputs.poses import Z
from ..inputs.tasks import ends
from .limb_models import LIMB_MODELS, LimbModel, bind

SIZES = (100_000, 1_000_000, 5_000_000)
MOST_OF_SURFACE = 1_500_000
CONTROL_POINTS = 10_000
FRAMES, FRAME_ITERATIONS = 16, 4
ROUNDS = 3
LIFT = 0.1  # of the ears, a share of the diagonal
TIMEOUT_S = 300.0


def measure_cost(most: int) -> list[dict[str, Any]]:
    """A row for each size and model; the lattice is the same at all sizes.

    Models take turns, so that a busy machine delays all alike; a row has the medians of the rounds.
    """
    cube_size = size_for(CONTROL_POINTS, creature(10_000))
    rows: list[dict[str, Any]] = []
    for size in (size for size in SIZES if size <= most):
        is_large = size > MOST_OF_SURFACE
        models = [model for model in LIMB_MODELS if not (is_large and model == "surface")]
        rounds = [[measured(size, model, cube_size) for model in models] for _ in range(ROUNDS)]
        for model, found in zip(models, zip(*rounds, strict=True), strict=True):
            row = {"model": model, **medians(found)}
            if not is_large and "not_run" not in row:
                row["to_surface"] = ratio(found, [in_round[0] for in_round in rounds])
            rows.append(row)
            print(f"cost: {row}", file=sys.stderr, flush=True)
    return rows


def measured(size: int, model: LimbModel, cube_size: float) -> dict[str, Any]:
    """What ``measure_one`` finds in a process of its own, or why it finds nothing."""
    command = [sys.executable, "-m", "measure.runs.cost", str(size), model, str(cube_size)]
    try:
        with Worker(command, timeout_s=TIMEOUT_S) as worker:
            return worker.ask("measure")
    except NotRun as reason:
        return {"not_run": str(reason)}


def medians(found: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Of each figure of several rounds; the first round that failed says why."""
    failed = [row for row in found if "not_run" in row]
    return failed[0] if failed else {key: median(row[key] for row in found) for key in found[0]}


def ratio(found: Sequence[dict[str, Any]], surface: Sequence[dict[str, Any]]) -> float | None:
    """The median of the rounds' ratios of a frame to that of the surface."""
    if any("not_run" in row for row in surface):
        return None
    return float(median(row["frame_s"] / of["frame_s"] for row, of in zip(found, surface, strict=True)))


def size_for(control_points: int, mesh: Mesh) -> float:
    """The size of cubes with which a mesh has about so many control points."""
    low, high = 0.005, 0.1
    for _ in range(12):
        middle = 0.5 * (low + high)
        bound = bind(mesh, "solid", middle)
        assert isinstance(bound, arap_native.LatticeArap)
        low, high = (middle, high) if bound.n_control_points > control_points else (low, middle)
    return 0.5 * (low + high)


def measure_one(size: int, model: LimbModel, cube_size: float) -> dict[str, Any]:
    """One size and model: the paws held, the ears lifted in even frames."""
    mesh = creature(size)
    held, moved = ends(mesh, 2)
    n = len(mesh.positions)
    out = np.zeros((n, 3), dtype=np.float32)
    out[:] = 1.0  # its memory counts before
    gc.collect()
    Path("/proc/self/clear_refs").write_text("5")  # the peak starts here
    before = process_memory("VmRSS")
    start = time.perf_counter()
    bound = bind(mesh, model, cube_size)
    bind_s = time.perf_counter() - start
    start = time.perf_counter()
    bound.set_constraints(np.concatenate([held, moved]))
    constraints_s = time.perf_counter() - start
    frames = drag(bound, mesh.positions[held], mesh.positions[moved], out)
    return {
        "n_vertices": n,
        "control_points": getattr(bound, "n_control_points", 0),
        "bind_s": bind_s,
        "constraints_s": constraints_s,
        "frame_s": median(frames),
        "bytes_a_vertex": (process_memory("VmRSS") - before) / n,
        "peak_bytes_a_vertex": (process_memory("VmHWM") - before) / n,
    }


def drag(bound: arap_native.Model, held: Floats, moved: Floats, out: NDArray[np.float32]) -> list[float]:
    """Seconds of each frame but the first four."""
    options = arap_native.SolveOptions(max_iterations=FRAME_ITERATIONS, accuracy=1e-7)
    times = []
    for frame in range(1, FRAMES + 1):
        targets = np.concatenate([held, moved + LIFT * frame / FRAMES * Z])
        start = time.perf_counter()
        bound.solve(targets, options, out=out)
        times.append(time.perf_counter() - start)
    return times[4:]


def main() -> None:
    size, model, cube_size = sys.argv[1:]
    input()
    chosen = next(known for known in LIMB_MODELS if known == model)
    print(json.dumps(measure_one(int(size), chosen, float(cube_size))), flush=True)


if __name__ == "__main__":
    main()
