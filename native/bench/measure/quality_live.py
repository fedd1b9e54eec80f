# SPDX-License-Identifier: GPL-3.0-or-later
"""A drag in the time that a frame has, and a pose beside its mirror image: on the creature in quads."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from . import machine
from .meshes import Mesh, creature
from .poses import STEPS, Pose, cub_parts, large_move_of, turned
from .posing import TOLERANCE, ModelName, Posing, options_of
from .shape import mirror_partners

FRAMES = 60
FRAME_S = 0.014
DRAG_VERTICES, SYMMETRY_VERTICES = 100_000, 10_000
CONVERGED_S = 4.0  # at most, of a frame's converged pose
SYMMETRY_TOLERANCES = (TOLERANCE, 1e-10)
SYMMETRY_S = 30.0


def measure_drag(model: ModelName) -> dict[str, Any]:
    """How far each frame of a drag is from the pose that it would converge to, as fractions of the diagonal.

    The head goes where the pose "large move" puts it, in 60 even frames. Each starts from the one before.
    """
    pose = large_move_of(creature(DRAG_VERTICES), DRAG_VERTICES)
    shares = [(frame + 1) / FRAMES for frame in range(FRAMES)]
    posing = Posing(pose, options_of(model))
    posing.frame(0.0, FRAME_S, np.empty(pose.mesh.positions.shape, dtype=np.float32))  # the first touch of its memory
    posing.reset()
    live = np.empty((FRAMES, *pose.mesh.positions.shape), dtype=np.float32)
    iterations = [posing.frame(share, FRAME_S, out) for share, out in zip(shares, live, strict=True)]
    posing.reset()
    behind = []
    is_converged = True
    for share, positions in zip(shares, live, strict=True):
        posed = posing.follow(share, CONVERGED_S)
        is_converged &= posed.is_converged
        behind.append(float(np.linalg.norm(positions - posed.positions, axis=1).max()))
    row = {
        "n_vertices": len(pose.mesh.positions),
        "load": machine.description()["load"],
        "frame_ms": 1e3 * FRAME_S,
        "iterations": iterations,
        "behind": behind,
        "is_converged": is_converged,
    }
    print(f"drag, {model}: {row}", file=sys.stderr, flush=True)
    return row


def measure_symmetry(model: ModelName) -> dict[str, Any]:
    """How far the mirrored result is from the result of the mirrored pose at most; a paw lifted to the side."""
    mesh = creature(SYMMETRY_VERTICES)
    partners = mirror_partners(mesh.positions, 0)
    flip = np.array([-1.0, 1.0, 1.0])
    left = _paw_lifted(mesh)
    right = left._replace(
        held=partners[left.held],
        moved=partners[left.moved],
        motion=lambda p, share: flip * left.motion(flip * p, share),
    )
    postures = [Posing(pose, options_of(model)) for pose in (left, right)]
    row: dict[str, Any] = {"n_vertices": len(mesh.positions), "distances": []}
    for tolerance in SYMMETRY_TOLERANCES:
        results = [posing.pose(STEPS, SYMMETRY_S, tolerance).positions for posing in postures]
        distance = float(np.linalg.norm(results[0] - flip * results[1][partners], axis=1).max())
        row["distances"].append([tolerance, distance])
    row["moved"] = float(np.linalg.norm(results[0] - mesh.positions, axis=1).max())
    print(f"symmetry, {model}: {row}", file=sys.stderr, flush=True)
    return row


def _paw_lifted(mesh: Mesh) -> Pose:
    parts, metre = cub_parts(SYMMETRY_VERTICES)
    held = np.concatenate([parts[name] for name in ("Paw front R", "Paw hind L", "Paw hind R")])
    motion = turned(np.array([1.0, 0.7, 0.3]), np.array([0.19, -0.24, 0.42]) * metre, -1.0)
    pose = large_move_of(mesh, SYMMETRY_VERTICES)
    return pose._replace(name="paw lifted", held=held, moved=parts["Paw front L"], motion=motion)
