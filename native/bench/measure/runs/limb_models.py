# SPDX-License-Identifier: GPL-3.0-or-later
"""A surface, a solid and a solid that keeps its volume, in the same poses; and linear skinning."""

from __future__ import annotations

import time
from typing import Literal, NamedTuple

import arap_native
import numpy as np

from ..inputs.limbs import Limb, second_bone_targets
from ..inputs.mesh import Floats, Ints, Mesh
from ..inputs.poses import Pose

LimbModel = Literal["surface", "solid", "firm"]
LIMB_MODELS: tuple[LimbModel, ...] = ("surface", "solid", "firm")
ACCURACY = 1e-5  # of each step, a fraction of the diagonal
NO_VERTICES = np.empty(0, dtype=np.int32)


class Reached(NamedTuple):
    """Positions (n, 3), and what all steps to them took."""

    positions: Floats
    iterations: int
    s: float


def bind(mesh: Mesh, model: LimbModel, cube_size: float) -> arap_native.Model:
    """A mesh bound. ``cube_size`` is a fraction of the diagonal, 0 is automatic; "firm" is Keep Volume 1."""
    arrays = mesh.positions, mesh.corner_vertices, mesh.face_sizes
    if model == "surface":
        return arap_native.SurfaceArap(*arrays)
    keep_volume = 1.0 if model == "firm" else 0.0
    return arap_native.LatticeArap(
        *arrays, options=arap_native.LatticeOptions(cube_size=cube_size, keep_volume=keep_volume)
    )


def pose_limb(limb: Limb, model: LimbModel) -> Reached:
    """By its bones where it has some and the model has an inside, else by the vertices held and moved."""
    bound = bind(limb.pose.mesh, model, limb.cube_size)
    if limb.bones is None or model == "surface":
        return pose_vertices(limb.pose, bound)
    bones, motion = limb.bones, limb.pose.motion
    bound.set_constraints(NO_VERTICES, segments=bones)
    return _in_steps(bound, [second_bone_targets(bones, motion, share) for share in _shares(limb.pose)])


def pose_vertices(pose: Pose, bound: arap_native.Model) -> Reached:
    """A pose by its vertices, and by its patch where it has one, from rest in even steps."""
    around, weights, at_rest = _patch(pose)
    patches = (np.array([0, len(around)], dtype=np.int32), around, weights) if pose.patch_radius else None
    bound.set_constraints(pose.task(0.0).vertices, patches=patches)
    targets = [np.concatenate([pose.task(share).targets, pose.motion(at_rest, share)]) for share in _shares(pose)]
    return _in_steps(bound, targets)


def _patch(pose: Pose) -> tuple[Ints, Floats, Floats]:
    """The patch around the moved vertex: its vertices, their weights, and its average (k, 3), none without patch."""
    if not pose.patch_radius:
        return NO_VERTICES, np.empty(0), np.empty((0, 3))
    mesh = pose.mesh
    surface = arap_native.SurfaceArap(mesh.positions, mesh.corner_vertices, mesh.face_sizes)
    around, weights, average = surface.patch_around(pose.moved, pose.patch_radius)
    return around, weights, average[None]


def _shares(pose: Pose) -> list[float]:
    return [step / pose.steps for step in range(1, pose.steps + 1)]


def _in_steps(bound: arap_native.Model, targets: list[Floats]) -> Reached:
    options = arap_native.SolveOptions(accuracy=ACCURACY)
    start = time.perf_counter()
    results = [bound.solve(np.ascontiguousarray(of_step), options) for of_step in targets]
    return Reached(results[-1].positions, sum(result.iterations for result in results), time.perf_counter() - start)


def skinned(limb: Limb, weights: Floats) -> Floats:
    """(n, 3) linear blend skinning: between rest and where the pose moves all."""
    rest = limb.pose.mesh.positions
    return np.asarray(rest + weights[:, None] * (limb.pose.motion(rest, 1.0) - rest))
