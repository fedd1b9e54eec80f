# SPDX-License-Identifier: GPL-3.0-or-later
"""How good poses look at several densities: plain spokes-and-rims beside rotation nodes.

    python -m measure.runs.quality OUT.json [--parts PART...] [--poses NAME...] [--levels N] [--budget S]

What is measured takes the place of what the file holds of the same kind, so that parts can be run alone. Deformed
meshes for the pictures go to the folder of the file's name beside it. The poses are those of the samples, and two of
each mesh that ARAP_BENCH_MESHES names.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from ..base import machine
from ..inputs.kinds import Kind, kinds
from ..inputs.mesh import Floats, named_meshes
from ..inputs.poses import STEPS, Pose, finer, named_poses, sample_poses
from ..metrics.shape import Surface, facing, largest_distance, thickness
from .live import measure_drag, measure_symmetry
from .posing import MODELS, ModelName, Posing

PARTS = ("poses", "kinds", "drag", "symmetry")
MOST_VERTICES = 250_000
DESCENT_VERTICES = 60_000  # iterations are counted on meshes up to that size: every count takes several solves


def densities(pose: Pose, levels: int) -> Iterator[Pose]:
    """The pose and its finer ones, while they have not too many vertices."""
    for _ in range(levels):
        yield pose
        if 4 * len(pose.mesh.positions) > MOST_VERTICES:
            return
        pose = finer(pose)


def measure_density(pose: Pose, model: ModelName, budget_s: float) -> tuple[dict[str, Any], Floats]:
    """The row of one model at one density, and the deformed positions."""
    posing = Posing(pose, model)
    posed = posing.pose(pose.steps, budget_s)
    row: dict[str, Any] = {
        "n_vertices": len(pose.mesh.positions),
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


def measure_pose(pose: Pose, model: ModelName, args: argparse.Namespace, folder: Path) -> list[dict[str, Any]]:
    """The rows of a model, from coarse to fine; "moved" is how far the density before it is from it at most."""
    rows: list[dict[str, Any]] = []
    coarser: Floats | None = None
    for level, at in enumerate(densities(pose, args.levels)):
        row, positions = measure_density(at, model, args.budget)
        if coarser is not None:
            row["moved"] = largest_distance(positions[: len(coarser)], coarser)
        coarser = positions
        rows.append(row)
        save(folder / f"{file_name(at)}-{model}-{level}.npz", at, positions)
        print(f"{pose.mesh.name}, {pose.name}, {model}: {row}", file=sys.stderr, flush=True)
    return rows


def measure_kind(kind: Kind, model: ModelName, budget_s: float) -> tuple[dict[str, Any], Floats]:
    """The row of one model, and the deformed positions. Faces are those of the sound mesh, where one is known.

    "off" is how far the positions are at most from what is known of them.
    """

    def posed(pose: Pose) -> Floats:
        return Posing(pose, model).pose(pose.steps, budget_s).positions

    pose, seen = kind.pose, kind.sound or kind.pose
    positions = posed(pose)
    n = len(seen.mesh.positions)
    change = Surface(seen.mesh).change(positions[:n], seen.measured())
    row: dict[str, Any] = {"n_vertices": len(pose.mesh.positions), **change._asdict()}
    if kind.sound is not None:
        row["off"] = largest_distance(positions[:n], posed(kind.sound))
    elif kind.known is not None:
        vertices, places = kind.known
        row["off"] = largest_distance(positions[vertices], places)
    print(f"{pose.name}, {model}: {row}", file=sys.stderr, flush=True)
    return row, positions


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


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.runs.quality", description="How good poses look.")
    parser.add_argument("out", type=Path, help="the JSON file to write")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--poses", nargs="+", default=(), help="names of poses; all where none is named")
    parser.add_argument("--levels", type=int, default=3, help="densities, each four times the one before")
    parser.add_argument("--budget", type=float, default=12.0, help="seconds of the last step of a pose, and of a count")
    args = parser.parse_args()
    try:
        poses = chosen(chain(sample_poses(), *map(named_poses, named_meshes())), args.poses)
    except ValueError as error:
        parser.error(str(error))

    folder = args.out.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    results: dict[str, Any] = {"poses": {}, "kinds": {}, "drag": {}, "symmetry": {}}
    if args.out.exists():
        results |= json.loads(args.out.read_text())
    results["machine"] = machine.description()

    def write() -> None:
        args.out.write_text(json.dumps(results, indent=1))

    if "poses" in args.parts:
        if not args.poses:  # what no pose has the name of any more goes
            known = {file_name(pose) for pose in poses}
            results["poses"] = {name: entry for name, entry in results["poses"].items() if name in known}
        for pose in poses:
            about = {"mesh": pose.mesh.name, "pose": pose.name, "is_sample": pose.is_sample}
            rows = results["poses"].setdefault(file_name(pose), {**about, "rows": {}})["rows"]
            for model in MODELS:
                rows[model] = measure_pose(pose, model, args, folder)
                write()
    if "kinds" in args.parts:
        for kind in kinds():
            name = file_name(kind.pose)
            rows = results["kinds"].setdefault(name, {"name": kind.pose.name, "rows": {}})["rows"]
            for model in MODELS:
                rows[model], positions = measure_kind(kind, model, args.budget)
                save(folder / f"{name}-{model}.npz", kind.pose, positions)
    for model in MODELS:
        if "drag" in args.parts:
            results["drag"][model] = measure_drag(model)
        if "symmetry" in args.parts:
            results["symmetry"][model] = measure_symmetry(model)
    write()


if __name__ == "__main__":
    main()
