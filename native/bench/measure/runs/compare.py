# SPDX-License-Identifier: GPL-3.0-or-later
"""All models of the library on the same tasks: shape, agreement at doubled detail, time.

    python -m measure.runs.compare OUT.json [--tasks NAME...] [--models NAME...]

What is measured takes the place of what the file holds of the same task and model. Deformed meshes for the pictures go
to the folder of the file's name beside it.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import arap_native
import numpy as np

from ..base import machine
from ..inputs.compared import Compared, file_part, linear_part, tasks
from ..inputs.mesh import Floats, Mask, Mesh
from ..inputs.poses import Pose, finer
from .quality import file_name, save
from .sections import thinnest_section, volume
from .shape import Surface, largest_distance

ACCURACY = 1e-5  # of each step, a fraction of the diagonal
STEP_ITERATIONS = 200
Bind = Callable[[Mesh], arap_native.Model]


def surface(energy: Any) -> Bind:
    return lambda mesh: arap_native.SurfaceArap(*arrays(mesh), arap_native.Options(energy=energy))


def solid(keep_volume: float) -> Bind:
    return lambda mesh: arap_native.LatticeArap(*arrays(mesh), arap_native.LatticeOptions(keep_volume=keep_volume))


def poisson(propagation: Any) -> Bind:
    return lambda mesh: arap_native.PoissonEditing(*arrays(mesh), arap_native.PoissonOptions(propagation=propagation))


def graph(nodes: Any, weights: Any = "smooth") -> Bind:
    return lambda mesh: arap_native.EmbeddedDeformation(
        *arrays(mesh), arap_native.EmbeddedOptions(nodes=nodes, weights=weights)
    )


def arrays(mesh: Mesh) -> tuple[Any, Any, Any]:
    return mesh.positions, mesh.corner_vertices, mesh.face_sizes


MODELS: dict[str, Bind] = {
    "surface, rotation nodes": surface("rotation_nodes"),
    "surface, spokes and rims": surface("spokes_and_rims"),
    "surface, spokes": surface("spokes"),
    "solid": solid(0.0),
    "solid, Keep Volume": solid(1.0),
    "Poisson, harmonic": poisson("harmonic"),
    "Poisson, geodesic": poisson("geodesic"),
    "graph, affine": graph("affine"),
    "graph, rigid": graph("rigid"),
    "graph, as published": graph("affine", "nearest"),
}


class Reached(NamedTuple):
    """Positions (n, 3), the seconds of bind and constraints, and those of the last step."""

    positions: Floats
    set_up_s: float
    frame_s: float


def pose_with(bind: Bind, pose: Pose) -> Reached:
    """From rest in even steps. All models are told the turns of what is moved."""
    start = time.perf_counter()
    model = bind(pose.mesh)
    model.set_constraints(pose.task(0.0).vertices)
    set_up_s = time.perf_counter() - start
    options = arap_native.SolveOptions(accuracy=ACCURACY, max_iterations=STEP_ITERATIONS)
    for step in range(1, pose.steps + 1):
        share = step / pose.steps
        start = time.perf_counter()
        result = model.solve(pose.task(share).targets, options, rotations=rotations(pose, share))
    return Reached(result.positions, set_up_s, time.perf_counter() - start)


def rotations(pose: Pose, share: float) -> Floats:
    """(k, 3, 3) of the targets."""
    result = np.tile(np.eye(3), (len(pose.held) + len(pose.moved), 1, 1))
    result[len(pose.held) :] = linear_part(pose.motion, share)
    return result


def row_of(task: Compared, bind: Bind, reached: Reached) -> dict[str, Any]:
    """What became of the mesh; shares are of what is at rest, lengths of the diagonal."""
    pose, now = task.pose, reached.positions
    mesh = pose.mesh
    free = task.limb.is_measured if task.limb else is_free(pose)
    measured = Surface(mesh)
    change = measured.change(now, free)
    of_task = pose.task(1.0)
    return {
        "volume": volume(now, mesh.triangles) / volume(mesh.positions, mesh.triangles) if task.is_closed else None,
        "section": thinnest_section(task.limb, now) if task.limb else None,
        "strain": edge_strain(mesh, measured, now, free),
        "max_deg": change.max_deg,
        "flips": change.flips,
        "off": largest_distance(now[of_task.vertices], of_task.targets),
        "density": density_gap(bind, pose, now),
        "set_up_s": reached.set_up_s,
        "frame_s": reached.frame_s,
    }


def is_free(pose: Pose) -> Mask:
    result = np.ones(len(pose.mesh.positions), dtype=bool)
    result[pose.held] = result[pose.moved] = False
    return result


def edge_strain(mesh: Mesh, measured: Surface, now: Floats, free: Mask) -> float:
    """Root of the mean square of the edges' relative changes of length, of edges with a free end."""
    edges = measured.edges[free[measured.edges].any(axis=1)]
    before, after = (np.linalg.norm(p[edges[:, 0]] - p[edges[:, 1]], axis=1) for p in (mesh.positions, now))
    return float(np.sqrt(np.mean((after / before - 1.0) ** 2)))


def density_gap(bind: Bind, pose: Pose, now: Floats) -> float:
    """How far a vertex is from where it is on the mesh whose triangles are cut in four."""
    return largest_distance(pose_with(bind, finer(pose)).positions[: len(now)], now)


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.runs.compare", description="All models on the same tasks.")
    parser.add_argument("out", type=Path, help="the JSON file to write")
    parser.add_argument("--tasks", nargs="+", help="names of files, as bar_twist_by_135; all by default")
    parser.add_argument("--models", nargs="+", choices=MODELS, default=list(MODELS))
    args = parser.parse_args()
    folder = args.out.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    results: dict[str, Any] = json.loads(args.out.read_text()) if args.out.exists() else {"tasks": {}}
    for task in tasks():
        pose, name = task.pose, file_name(task.pose)
        if args.tasks and name not in args.tasks:
            continue
        entry = results["tasks"].setdefault(name, {"mesh": pose.mesh.name, "pose": pose.name, "rows": {}})
        entry["n_vertices"] = len(pose.mesh.positions)
        for model in args.models:
            reached = pose_with(MODELS[model], pose)
            entry["rows"][model] = row_of(task, MODELS[model], reached)
            save(folder / f"{name}-{file_part(model)}.npz", pose, reached.positions)
            print(f"{name}, {model}: {entry['rows'][model]}", file=sys.stderr, flush=True)
        results["machine"] = machine.description()
        args.out.write_text(json.dumps(results, indent=1))


if __name__ == "__main__":
    main()
