# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses as the arrays that contenders get."""

from __future__ import annotations

from collections.abc import Sequence

import arap_native
import numpy as np

from ..base.contender import Bones, PosedTask
from ..inputs.bones import Bone
from ..inputs.compared import linear_part
from ..inputs.poses import Pose


def posed_task(pose: Pose, bones: Sequence[Bone] = ()) -> PosedTask:
    """A pose from rest in its even steps, by vertices, or by a patch where it has one; and by bones, if some do it."""
    mesh, moved, weights = pose.mesh, pose.moved, None
    if pose.patch_radius:
        surface = arap_native.SurfaceArap(mesh.positions, mesh.corner_vertices, mesh.face_sizes)
        moved, weights, _ = surface.patch_around(pose.moved, pose.patch_radius)
    shares = [step / pose.steps for step in range(1, pose.steps + 1)]
    rest = mesh.positions
    return PosedTask(
        rest,
        mesh.corner_vertices,
        mesh.face_sizes,
        pose.held,
        moved,
        np.stack([np.concatenate([rest[pose.held], pose.motion(rest[moved], share)]) for share in shares]),
        np.stack([linear_part(pose.motion, share) for share in shares]),
        weights,
        posed_bones(bones, shares) if bones else None,
    )


def posed_bones(bones: Sequence[Bone], shares: Sequence[float]) -> Bones:
    """Bones that each make their motion to these shares of it."""
    return Bones(
        np.stack([[bone.head, bone.tail] for bone in bones]),
        np.stack([[linear_part(bone.motion, share) for bone in bones] for share in shares]),
        np.stack([[bone.motion(bone.head[None], share)[0] for bone in bones] for share in shares]),
    )
