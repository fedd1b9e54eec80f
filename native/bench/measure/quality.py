# SPDX-License-Identifier: GPL-3.0-or-later
"""How good poses look at several densities: plain spokes-and-rims beside rotation nodes.

    python -m measure.quality OUT.json [--parts poses kinds drag symmetry] [--poses NAME...] [--models plain nodes]
        [--levels N] [--budget S] [--most-vertices N]

What is measured takes the place of what the file holds of the same kind, so that parts can be run alone. Deformed
meshes for the pictures go to the folder of the file's name beside it. The poses are those of the samples, and two of
each mesh that ARAP_BENCH_MESHES names.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from . import machine
from .kinds import kinds
from .meshes import Floats, load_off, mesh_files
from .poses import STEPS, Pose, finer, named_poses, sample_poses
from .posing import MODELS, ModelName, Posing, options_of, reason_against
from .quality_kinds import measure_kind
from .quality_live import measure_drag, measure_symmetry
from .shape import Surface, facing, largest_distance, thickness

PARTS = ("poses", "kinds", "drag", "symmetry")
DESCENT_VERTICES = 60_000  # iterations are counted on meshes up to that size: every count takes several solves


def all_poses() -> Iterator[Pose]:
    yield from sample_poses()
    for path in mesh_files(os.environ.get("ARAP_BENCH_MESHES", "")):
        yield from named_poses(load_off(path))


def densities(pose: Pose, levels: int, most_vertices: int) -> Iterator[Pose]:
    """The pose and its finer ones, while they have not too many vertices."""
    for _ in range(levels):
        yield pose
        if 4 * len(pose.mesh.positions) > most_vertices:
            return
        pose = finer(pose)


def measure_density(pose: Pose, model: ModelName, budget_s: float) -> tuple[dict[str, Any], Floats]:
    """The row of one model at one density, and the deformed positions."""
    posing = Posing(pose, options_of(model))
    posed = posing.pose(pose.steps, budget_s)
    row: dict[str, Any] = {
        "n_vertices": len(pose.mesh.positions),
        "energy": posed.energy,
        "is_converged": posed.is_converged,
        **Surface(pose.mesh).change(posed.positions, pose.measured())._asdict(),
        "near": posing.iterations_near(budget_s) if len(pose.mesh.positions) <= DESCENT_VERTICES else None,
    }
    if pose.steps < STEPS:
        row["from_steps"] = largest_distance(posed.positions, posing.pose(STEPS, budget_s).positions)
    if pose.walls_axis is not None:
        front, back = facing(pose.mesh.positions, pose.walls_axis)
        is_free = pose.measured()[front]
        kept = thickness(pose.mesh, front[is_free], back[is_free], posed.positions)
        row["walls"] = {"passed": float(np.mean(kept < 0.0)), "median": float(np.median(kept))}
    return row, posed.positions


def measure_pose(
    pose: Pose, model: ModelName, levels: int, most_vertices: int, budget_s: float, folder: Path
) -> list[dict[str, Any]]:
    """The rows of a model, from coarse to fine; "moved" is how far the density before it is from it at most."""
    rows: list[dict[str, Any]] = []
    coarser: Floats | None = None
    for level, at in enumerate(densities(pose, levels, most_vertices)):
        row, positions = measure_density(at, model, budget_s)
        if coarser is not None:
            row["moved"] = largest_distance(positions[: len(coarser)], coarser)
        coarser = positions
        rows.append(row)
        save(folder / f"{file_name(at)}-{model}-{level}.npz", at, positions)
        print(f"{pose.mesh.name}, {pose.name}, {model}: {row}", file=sys.stderr, flush=True)
    return rows


def file_name(pose: Pose) -> str:
    return f"{pose.mesh.name} {pose.name}".replace(",", "").replace(" ", "_")


def save(path: Path, pose: Pose, positions: Floats) -> None:
    """What a picture of a deformed mesh needs."""
    part = np.zeros(len(positions), dtype=np.int32)
    part[pose.held], part[pose.moved] = 1, 2
    np.savez(
        path,
        positions=positions.astype(np.float32),
        triangles=pose.mesh.triangles,
        part=part,
        eye=np.array(pose.view.eye),
        middle=np.array(pose.view.middle),
        height=pose.view.height,
    )


def chosen(poses: Iterable[Pose], names: Sequence[str]) -> list[Pose]:
    """The poses of these names, all where there are none; raises ValueError for a name that no pose has."""
    poses = list(poses)
    known = dict.fromkeys(pose.name for pose in poses)
    unknown = [name for name in names if name not in known]
    if unknown:
        raise ValueError(f"no pose is named {quoted(unknown)}; the names are {quoted(known)}")
    return [pose for pose in poses if not names or pose.name in names]


def quoted(names: Iterable[str]) -> str:
    return ", ".join(f'"{name}"' for name in names)


def measure_poses(
    results: dict[str, Any], args: argparse.Namespace, poses: Sequence[Pose], models: Sequence[ModelName], folder: Path
) -> None:
    """Adds the rows of each pose and model to the results."""
    for pose in poses:
        entry = results["poses"].setdefault(file_name(pose), {"mesh": pose.mesh.name, "pose": pose.name, "rows": {}})
        entry["is_sample"] = pose.is_sample
        for model in models:
            rows = measure_pose(pose, model, args.levels, args.most_vertices, args.budget, folder)
            entry["rows"][model] = rows
            write(args.out, results)


def measure_kinds(results: dict[str, Any], models: Sequence[ModelName], budget_s: float, folder: Path) -> None:
    """Adds the row of each kind of mesh and model to the results."""
    for kind in kinds():
        name = file_name(kind.pose)
        rows = results["kinds"].setdefault(name, {"name": kind.pose.name, "rows": {}})["rows"]
        for model in models:
            rows[model], positions = measure_kind(kind, model, budget_s)
            save(folder / f"{name}-{model}.npz", kind.pose, positions)


def write(path: Path, results: dict[str, Any]) -> None:
    path.write_text(json.dumps(results, indent=1))


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.quality", description="How good poses look at several densities.")
    parser.add_argument("out", type=Path, help="the JSON file to write")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--poses", nargs="+", default=(), help="names of poses; all where none is named")
    parser.add_argument("--models", nargs="+", choices=tuple(MODELS), default=tuple(MODELS))
    parser.add_argument("--levels", type=int, default=3, help="densities, each four times the one before")
    parser.add_argument("--most-vertices", type=int, default=250_000)
    parser.add_argument("--budget", type=float, default=12.0, help="seconds of the last step of a pose, and of a count")
    args = parser.parse_args()
    try:
        poses = chosen(all_poses(), args.poses)
    except ValueError as error:
        parser.error(str(error))

    folder = args.out.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    results: dict[str, Any] = {"poses": {}, "kinds": {}, "drag": {}, "symmetry": {}}
    if args.out.exists():
        results |= json.loads(args.out.read_text())
    results["machine"] = machine.description()
    results["not_run"] = {model: reason for model in args.models if (reason := reason_against(model))}
    models = [model for model in args.models if model not in results["not_run"]]
    if "poses" in args.parts:
        if not args.poses:  # what no pose has the name of any more goes
            known = {file_name(pose) for pose in poses}
            results["poses"] = {name: entry for name, entry in results["poses"].items() if name in known}
        measure_poses(results, args, poses, models, folder)
    if "kinds" in args.parts:
        measure_kinds(results, models, args.budget, folder)
    for model in models:
        if "drag" in args.parts:
            results["drag"][model] = measure_drag(model)
        if "symmetry" in args.parts:
            results["symmetry"][model] = measure_symmetry(model)
        write(args.out, results)


if __name__ == "__main__":
    main()
