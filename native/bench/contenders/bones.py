# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones for a task that has none."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from arap_deform.core.graph import connected_labels, face_edges
from measure.base.contender import Bones, Floats, Ints, PosedTask
from measure.base.workers import NotRun

from .steps import diagonal, motion_of_moved

SHARE = 0.8  # of a piece's length
SHORTEST = 0.01  # of the diagonal
SMALL = 0.1  # of the vertices: a piece that has no bone of its own


def bones_of(task: PosedTask) -> Bones:
    """One along each connected piece of what is held, which stays, and of what is moved, which goes along.

    Raises:
        NotRun: a piece that is held is around one that is moved, so that it has no inside of its own for a bone.
    """
    held, moved = (
        [bone_along(task.positions[piece], SHORTEST * diagonal(task)) for piece in pieces(task, part)]
        for part in (task.held, task.moved)
    )
    rest = np.array(held + moved)
    middles = rest.mean(axis=1)
    apart = np.linalg.norm(middles[: len(held), None] - middles[len(held) :], axis=2)
    if apart.min() < SHORTEST * diagonal(task):
        raise NotRun("what is held is all around what is moved: there is no place for a bone in each")
    rotations = np.tile(np.eye(3), (task.steps, len(rest), 1, 1))
    heads = np.tile(rest[:, 0], (task.steps, 1, 1))
    for step in range(task.steps):
        turn, shift = motion_of_moved(task, step)
        rotations[step, len(held) :] = turn
        heads[step, len(held) :] = rest[len(held) :, 0] @ turn.T + shift
    return Bones(rest, rotations, heads)


def pieces(task: PosedTask, vertices: Ints) -> Iterator[Ints]:
    """The vertices (k,) in pieces that sides of faces connect; all that are smaller than SMALL are one."""
    is_in = np.zeros(len(task.positions), dtype=bool)
    is_in[vertices] = True
    ends = np.stack(face_edges(task.corner_vertices, task.face_sizes))
    labels = connected_labels(len(is_in), *ends[:, is_in[ends].all(axis=0)])[vertices]
    _, piece, sizes = np.unique(labels, return_inverse=True, return_counts=True)
    piece = np.where(sizes[piece] < SMALL * len(vertices), -1, piece)
    for k in np.unique(piece):
        yield vertices[piece == k]


def bone_along(points: Floats, shortest: float) -> Floats:
    """(2, 3) head and tail, along the direction in which points (k, 3) reach farthest, about their middle."""
    middle = points.mean(axis=0)
    _, _, axes = np.linalg.svd(points - middle, full_matrices=True)
    along = (points - middle) @ axes[0]
    low, high = SHARE * along.min(), SHARE * along.max()
    reach = max(0.0, shortest - (high - low))
    return np.stack([middle + (low - 0.5 * reach) * axes[0], middle + (high + 0.5 * reach) * axes[0]])
