# SPDX-License-Identifier: GPL-3.0-or-later
"""What a solid does beside a surface: limbs twisted and bent, two fingers, other densities and lattices, and its cost.

    python -m measure.runs.limbs OUT.json [--parts PART...] [--most VERTICES]

What is measured takes the place of what the file holds of the same part. Deformed meshes for the pictures go to the
folder of the file's name beside it. A leg of armadillo_43k is measured, too, if ARAP_BENCH_MESHES names it.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from ..base.parts import measure_parts
from ..inputs.limbs import ACROSS, FINGER, ROD_AROUND, Limb, creature_legs, fingers, legs, rods
from ..inputs.mesh import Floats
from ..inputs.poses import Y
from ..inputs.tasks import rotation
from ..metrics.sections import thinnest_section, volume
from ..metrics.shape import Surface, largest_distance
from .cost import measure_cost
from .limb_models import LIMB_MODELS, Reached, bind, pose_limb, pose_vertices, skinned
from .quality import file_name, save
from .steady import measure_densities, measure_turned

PARTS = ("limbs", "fingers", "densities", "turned", "cost")
STRIPES = 4  # of a rod


def measure_limbs(folder: Path) -> dict[str, Any]:
    """For each limb the rows of the models, and of linear skinning where the limb has weights."""
    found: dict[str, Any] = {}
    for limb in chain(rods(), creature_legs(), legs(os.environ.get("ARAP_BENCH_MESHES", ""))):
        pose = limb.pose
        posed = {str(model): pose_limb(limb, model) for model in LIMB_MODELS}
        if limb.weights is not None:
            posed["skinned"] = Reached(skinned(limb, limb.weights), 0, 0.0)
        rows = {model: row_of(limb, reached) for model, reached in posed.items()}
        found[file_name(pose)] = {"mesh": pose.mesh.name, "pose": pose.name, "is_sample": pose.is_sample, "rows": rows}
        for model, reached in posed.items():
            if pose.is_sample:
                save_picture(folder / f"{file_name(pose)}-{model}.npz", limb, reached.positions)
            print(f"{pose.mesh.name}, {pose.name}, {model}: {rows[model]}", file=sys.stderr, flush=True)
    return found


def row_of(limb: Limb, reached: Reached) -> dict[str, Any]:
    """The volume and the thinnest section over those at rest, and the largest change of an angle away from handles."""
    mesh = limb.pose.mesh
    volumes = [volume(positions, mesh.triangles) for positions in (reached.positions, mesh.positions)]
    return {
        "volume": volumes[0] / volumes[1],
        "section": thinnest_section(limb, reached.positions),
        "max_deg": Surface(mesh).change(reached.positions, limb.is_measured).max_deg,
        "iterations": reached.iterations,
        "s": reached.s,
    }


def save_picture(path: Path, limb: Limb, positions: Floats) -> None:
    """A rod with bones, which hold no vertices, has stripes: they show a twist."""
    save(path, limb.pose, positions)
    if limb.bones is None:
        return
    with np.load(path) as data:
        kept = dict(data)
    kept["part"] = (np.arange(len(positions)) % ROD_AROUND * 2 * STRIPES // ROD_AROUND % 2).astype(np.int32)
    kept["positions"] = (positions @ rotation(Y, np.radians(limb.tilt_deg)).T).astype(np.float32)
    np.savez(path, **kept)


def measure_fingers() -> list[dict[str, Any]]:
    """How far one finger moves at most when the other is turned, in lengths where a finger is 2 long."""
    pose, is_other, width = fingers()
    rows: list[dict[str, Any]] = []
    cases = [
        (model, size) for model in LIMB_MODELS for size in (0.0, width / ACROSS) if model != "surface" or size == 0.0
    ]
    for model, cube_size in cases:
        bound = bind(pose.mesh, model, cube_size)
        moved = largest_distance(pose_vertices(pose, bound).positions[is_other], pose.mesh.positions[is_other])
        size = getattr(bound, "cube_size", None)
        rows.append({"model": model, "cubes": size and width / size, "moved": moved * FINGER / width})
        print(f"fingers: {rows[-1]}", file=sys.stderr, flush=True)
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.runs.limbs", description="A solid beside a surface.")
    parser.add_argument("out", type=Path, help="the JSON file to write")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--most", type=int, default=5_000_000, help="vertices of the largest mesh of the cost")
    args = parser.parse_args()

    folder = args.out.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    measures: dict[str, Callable[[], Any]] = {
        "limbs": lambda: measure_limbs(folder),
        "fingers": measure_fingers,
        "densities": measure_densities,
        "turned": measure_turned,
        "cost": lambda: measure_cost(args.most),
    }
    measure_parts(args.out, args.parts, measures)


if __name__ == "__main__":
    main()
