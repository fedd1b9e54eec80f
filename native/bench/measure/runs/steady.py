# SPDX-License-Identifier: GPL-3.0-or-later
"""How steady a pose is: at other densities of the mesh, and with the lattice's cubes lying otherwise in it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import combinations
from typing import Any

import arap_native
import numpy as np

from ..inputs.limbs import LIMB_STEPS, rods
from ..inputs.mesh import Floats, Mesh, unscaled
from ..inputs.poses import PULL_RADIUS, Pose, finer, knee, pull
from ..inputs.tasks import rotation
from .limb_models import LimbModel, bind, pose_vertices

LEVELS = 3  # densities, each four times the one before
MODELS: tuple[LimbModel, ...] = ("surface", "solid")
TURNS = (((0.3, 1.0, 0.2), 17.0), ((1.0, 0.5, -0.4), 33.0), ((0.2, -0.3, 1.0), 45.0))  # axes, degrees


def poses() -> Iterator[Pose]:
    for pose in (knee(), pull("pull, patch", PULL_RADIUS)):
        yield pose._replace(steps=LIMB_STEPS)


def measure_densities() -> list[dict[str, Any]]:
    """For each pose and model how far the vertices of a density are from themselves at the next finer one."""
    rows: list[dict[str, Any]] = []
    for base in poses():
        for model in MODELS:
            pose, coarser, counts, gaps = base, None, [], []
            for level in range(LEVELS):
                pose = finer(pose) if level else base
                positions = pose_vertices(pose, bind(pose.mesh, model, 0.0)).positions
                if coarser is not None:
                    gaps.append(_gap(positions[: len(coarser)], coarser))
                coarser = positions
                counts.append(len(positions))
            about = {"mesh": base.mesh.name, "pose": base.name, "model": model, "n_vertices": counts}
            rows.append({**about, "gaps": gaps})
            print(f"densities: {rows[-1]}", file=sys.stderr, flush=True)
    return rows


def measure_turned() -> list[dict[str, Any]]:
    """How far a pose is from the same pose of the mesh turned and moved, then put back; cubes of one size.

    "pairs" is the same of two turned meshes, where they differ most.
    """
    rows: list[dict[str, Any]] = []
    twisted = next(rods())
    for pose, cube_size in (*((pose, 0.0) for pose in poses()), (twisted.pose, twisted.cube_size)):
        straight = bind(pose.mesh, "solid", cube_size)
        assert isinstance(straight, arap_native.LatticeArap)
        size = straight.cube_size
        reference = pose_vertices(pose, straight).positions
        found: list[Floats] = []
        for axis, degrees in TURNS:
            turn, shift = rotation(np.array(axis), np.radians(degrees)), size * np.array([0.37, 0.55, 0.21])
            moved = turned_pose(pose, turn, shift)
            bound = bind(moved.mesh, "solid", size / diagonal(moved.mesh))
            found.append((pose_vertices(moved, bound).positions - shift) @ turn)
        gaps = [_gap(positions, reference) for positions in found]
        pairs = max((_gap(a, b) for a, b in combinations(found, 2)), key=lambda gap: gap["rms"])
        rows.append({"mesh": pose.mesh.name, "pose": pose.name, "gaps": gaps, "pairs": pairs})
        print(f"turned: {rows[-1]}", file=sys.stderr, flush=True)
    return rows


def turned_pose(pose: Pose, turn: Floats, shift: Floats) -> Pose:
    """The same pose of the mesh turned and moved."""
    mesh, motion = pose.mesh, pose.motion

    def moved(points: Floats, share: float) -> Floats:
        return np.asarray(motion((points - shift) @ turn, share) @ turn.T + shift)

    rigid = unscaled(mesh.name, mesh.positions @ turn.T + shift, mesh.triangles)
    return pose._replace(mesh=rigid, motion=moved)


def diagonal(mesh: Mesh) -> float:
    return float(np.linalg.norm(np.ptp(mesh.positions, axis=0)))


def _gap(a: Floats, b: Floats) -> dict[str, float]:
    """Largest distance and root of the mean square of all."""
    distances = np.linalg.norm(a - b, axis=1)
    return {"max": float(distances.max()), "rms": float(np.sqrt(np.mean(distances**2)))}
