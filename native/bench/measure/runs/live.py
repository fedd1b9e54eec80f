# SPDX-License-Identifier: GPL-3.0-or-later
"""A drag in the time that a frame has, and a pose beside its mirror image: on the creature in quads."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..base import machine
from ..inputs.mesh import Mesh, creature
from ..inputs.poses import STEPS, Pose, cub_partners, cub_parts, large_move_of, turned
from ..metrics.shape import largest_distance
from .posing import Limit, ModelName, Posing

FRAMES = 60
SHARES = [(frame + 1) / FRAMES for frame in range(FRAMES)]
FRAME_S = 0.014
FRAME_ITERATIONS = (1, 2, 3)
DRAG_VERTICES, SYMMETRY_VERTICES = 100_000, 10_000
CONVERGED_S = 4.0  # at most, of a frame's converged pose
SYMMETRY_ACCURACIES = (1e-4, 1e-6, 1e-8)
SYMMETRY_S = 30.0


def measure_drag(model: ModelName) -> dict[str, Any]:
    """How far each frame of a drag is from the pose that it would converge to, as fractions of the diagonal.

    The head goes where the pose "large move" puts it, in 60 even frames. Each starts from the one before. Beside what
    the time of a frame allows stand frames of so many iterations, which do not depend on the machine.
    """
    pose = large_move_of(creature(DRAG_VERTICES), DRAG_VERTICES)
    posing = Posing(pose, model)
    in_time = Limit(s=FRAME_S)
    posing.frame(0.0, in_time, np.empty(pose.mesh.positions.shape, dtype=np.float32))  # the first touch of its memory
    live, iterations = _drag(posing, pose, in_time)
    load = machine.description()["load"]
    of_iterations = {n: _drag(posing, pose, Limit(iterations=n))[0] for n in FRAME_ITERATIONS}
    posing.reset()
    behind: list[float] = []
    behind_of: dict[str, list[float]] = {str(n): [] for n in of_iterations}
    for frame, share in enumerate(SHARES):
        posed = posing.follow(share, CONVERGED_S)
        behind.append(largest_distance(live[frame], posed.positions))
        for n, frames in of_iterations.items():
            behind_of[str(n)].append(largest_distance(frames[frame], posed.positions))
    row = {
        "n_vertices": len(pose.mesh.positions),
        "load": load,
        "frame_ms": 1e3 * FRAME_S,
        "iterations": iterations,
        "behind": behind,
        "behind_of_iterations": behind_of,
    }
    print(f"drag, {model}: {row}", file=sys.stderr, flush=True)
    return row


def _drag(posing: Posing, pose: Pose, limit: Limit) -> tuple[NDArray[np.float32], list[int]]:
    """The frames from rest, (FRAMES, n, 3), and their iterations."""
    posing.reset()
    frames = np.empty((FRAMES, *pose.mesh.positions.shape), dtype=np.float32)
    return frames, [posing.frame(share, limit, out) for share, out in zip(SHARES, frames, strict=True)]


def measure_symmetry(model: ModelName) -> dict[str, Any]:
    """How far the mirrored result is from the result of the mirrored pose at most; a paw lifted to the side."""
    mesh = creature(SYMMETRY_VERTICES)
    partners = cub_partners(SYMMETRY_VERTICES)
    flip = np.array([-1.0, 1.0, 1.0])
    left = _paw_lifted(mesh)
    right = left._replace(
        held=partners[left.held],
        moved=partners[left.moved],
        motion=lambda p, share: flip * left.motion(flip * p, share),
    )
    postures = [Posing(pose, model) for pose in (left, right)]
    row: dict[str, Any] = {"n_vertices": len(mesh.positions), "distances": []}
    for accuracy in SYMMETRY_ACCURACIES:
        results = [posing.pose(STEPS, SYMMETRY_S, accuracy).positions for posing in postures]
        distance = largest_distance(results[0], flip * results[1][partners])
        row["distances"].append([accuracy, distance])
    row["moved"] = largest_distance(results[0], mesh.positions)
    print(f"symmetry, {model}: {row}", file=sys.stderr, flush=True)
    return row


def _paw_lifted(mesh: Mesh) -> Pose:
    parts, metre = cub_parts(SYMMETRY_VERTICES)
    held = np.concatenate([parts[name] for name in ("Paw front R", "Paw hind L", "Paw hind R")])
    motion = turned(np.array([1.0, 0.7, 0.3]), np.array([0.19, -0.24, 0.42]) * metre, -1.0)
    pose = large_move_of(mesh, SYMMETRY_VERTICES)
    return pose._replace(name="paw lifted", held=held, moved=parts["Paw front L"], motion=motion)
