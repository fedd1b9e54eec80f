# SPDX-License-Identifier: GPL-3.0-or-later
"""The tasks that all models of deformation are compared on: some vertices stay, some move, from rest in even steps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scenes.cactus import cactus, cactus_groups

from .bones import Bone, arc_between, cub_bones, rod_bones, twist_between
from .figure import Figure, arm_raised, figure
from .limbs import (
    BONE_END,
    LIMB_STEPS,
    ROD_HELD,
    ROD_LENGTH,
    Limb,
    along_arc,
    creature_legs,
    fingers,
    rod_by_ends,
    rod_mesh,
)
from .mesh import Floats, Ints, make_mesh, triangulated
from .poses import PULL_RADIUS, Pose, View, X, Y, Z, bar_bend, bar_twist, cub, large_move_of, pull, turned
from .solids import cut_apart, sheet
from .tasks import Motion

PLANE_CELLS, PLANE_HELD, PLANE_MOVED, PLANE_HEIGHT = 60, 0.46, 0.06, 0.3  # in widths, from the middle
ROD_VIEW = View((0.0, -1.0, 0.0), (0.22, 0.0, -0.1), 1.05)
ROD_ENDS = (1 / 12, 11 / 12)  # of its length: what is held and moved, see ROD_HELD
BAR_ENDS = (0.06, 0.94)
TWIST_ENDS = (0.2, 0.8)  # bones hold what is around them, so these reach farther
BEND, TWIST, CACTUS_BEND = np.radians(120), np.pi, np.radians(70)
SOUP_AROUND, SOUP_ALONG, SOUP_GAP = 24, 46, 0.02


class Compared(NamedTuple):
    """A task.

    Attributes:
        pose: of which the tables have a row for each model.
        limb: what its sections are measured with; None where it has none.
        is_closed: whether it has a volume.
        bones: that do it, for models that have bones; none where it is not done with bones.
        mirror: the axis across whose middle plane the task is its own mirror image; None where it is not.
        beside: (k, 2) vertices that lie side by side and should go on so.
        still: (k,) free vertices that should stay where they are.
    """

    pose: Pose
    limb: Limb | None = None
    is_closed: bool = True
    bones: tuple[Bone, ...] = ()
    mirror: int | None = None
    beside: Ints | None = None
    still: Ints | None = None


def tasks() -> Iterator[Compared]:
    yield Compared(plane(), is_closed=False, mirror=0)
    yield from bent_and_twisted_rods()
    yield from bent_and_twisted_bars()
    yield cactus_bent()
    yield from paws()
    yield arm_raised_by(figure(is_dressed=False))
    yield arm_raised_by(figure(is_dressed=True))
    turn = large_move_of(cub())._replace(name="head turned and moved", steps=LIMB_STEPS)
    yield Compared(turn, bones=cub_bones({"head": turn.motion}))
    yield translation()
    yield Compared(pull("pull", PULL_RADIUS)._replace(steps=LIMB_STEPS))
    yield fingers_close()
    yield soup()


def plane() -> Pose:
    """A square sheet, its border held, its middle pulled up without a turn."""
    mesh = make_mesh("plane", *sheet((1.0, 1.0), (PLANE_CELLS, PLANE_CELLS)))
    width = float(np.ptp(mesh.positions[:, 0]))
    away = np.abs(mesh.positions - [0.5 * width, 0.0, 0.0]).max(axis=1) / width
    held, moved = (np.flatnonzero(m).astype(np.int32) for m in (away > PLANE_HELD, away < PLANE_MOVED))
    view = View((0.4, -1.0, 0.6), (0.5 * width, 0.0, 0.3 * PLANE_HEIGHT * width), 1.5 * width)
    return Pose("pulled up", mesh, held, moved, moved_by(PLANE_HEIGHT * width * Z), view)


def bent_and_twisted_rods() -> Iterator[Compared]:
    """A cylinder, six times as long as thick, by its ends."""
    mesh, width = rod_mesh()
    length = (ROD_LENGTH - 2 * ROD_HELD) * width
    low, high = -BONE_END * width * Z, BONE_END * width * Z
    twist, bend = turned(Z, np.zeros(3), TWIST), along_arc(length, BEND)
    twisted, bent = rod_by_ends("twist by 180", mesh, width, twist), rod_by_ends("bend by 120", mesh, width, bend)
    for limb, between, ends, mirror in (
        (twisted, twist_between(Z, np.zeros(3), TWIST, ROD_ENDS), TWIST_ENDS, None),
        (bent, arc_between(-0.5 * length * Z, length, BEND, *ROD_ENDS), ROD_ENDS, 1),
    ):
        bones = rod_bones(low, high, ends, between, limb.pose.motion)
        yield Compared(limb.pose._replace(view=ROD_VIEW), limb, bones=bones, mirror=mirror)


def bent_and_twisted_bars() -> Iterator[Compared]:
    bend, twist = bar_bend()._replace(name="bend by 90"), bar_twist()._replace(name="twist by 135")
    length = float(np.ptp(bend.mesh.positions[:, 2]))
    for pose, between, ends in (
        (bend, arc_between(np.zeros(3), length, np.pi / 2), BAR_ENDS),
        (twist, twist_between(Z, np.zeros(3), 0.75 * np.pi, BAR_ENDS), TWIST_ENDS),
    ):
        yield Compared(pose, bones=rod_bones(np.zeros(3), length * Z, ends, between, pose.motion))


def cactus_bent() -> Compared:
    """The roots held, the top led along an arc; the arms are free."""
    model = cactus()
    mesh = triangulated(make_mesh("cactus", model.positions, model.quads))
    groups = cactus_groups(model)
    metre = 1.0 / float(np.linalg.norm(np.ptp(model.positions, axis=0)))
    low, high = (metre * z for z in (0.58, 1.78))
    bottom, top = (metre * z * Z for z in (0.40, 1.98))
    ends = (low - bottom[2]) / (top - bottom)[2], (high - bottom[2]) / (top - bottom)[2]
    between = arc_between(low * Z, high - low, CACTUS_BEND, *ends)
    motion = between(ends[1], ends[1])
    view = View((0.0, -1.0, 0.1), (0.12, 0.0, 0.42), 0.95)
    pose = Pose("bend by 70", mesh, groups["Roots"], groups["Top"], motion, view, LIMB_STEPS)
    return Compared(pose, bones=rod_bones(bottom, top, ends, between, motion), mirror=1)


def paws() -> Iterator[Compared]:
    for limb in creature_legs():
        yield Compared(limb.pose, limb, bones=cub_bones({"lower front L": limb.pose.motion}))


def translation() -> Compared:
    """The creature's head moved sideways without a turn, the paws held."""
    motion = moved_by(0.15 * X - 0.1 * Y)
    pose = large_move_of(cub())._replace(name="head moved only", motion=motion, steps=LIMB_STEPS)
    return Compared(pose, bones=cub_bones({"head": motion}))


def arm_raised_by(made: Figure) -> Compared:
    """A figure raises an arm. A shirt hangs at nothing but the body under it."""
    pose, bones = arm_raised(made)
    is_dressed = len(made.covers) > 0
    return Compared(pose, is_closed=not is_dressed, bones=bones, beside=made.covers if is_dressed else None)


def fingers_close() -> Compared:
    """Two fingers, a twentieth of their width apart; one is bent, the other should stay."""
    pose, is_other, _ = fingers()
    return Compared(pose._replace(name="one bent"), still=np.flatnonzero(is_other).astype(np.int32))


def soup() -> Compared:
    """The rod bent, each of its triangles by itself, smaller by a gap; corners that were one should stay together."""
    mesh, width = rod_mesh(SOUP_AROUND, SOUP_ALONG)
    length = (ROD_LENGTH - 2 * ROD_HELD) * width
    apart = cut_apart(mesh, SOUP_GAP)._replace(name="rod, faces cut apart")
    limb = rod_by_ends("bend by 120", apart, width, along_arc(length, BEND))
    corners = mesh.triangles.ravel()
    _, first, vertex = np.unique(corners, return_index=True, return_inverse=True)
    pairs = np.stack([first[vertex], np.arange(len(corners))], axis=1).astype(np.int32)
    return Compared(limb.pose._replace(view=ROD_VIEW), is_closed=False, beside=pairs[pairs[:, 0] != pairs[:, 1]])


def moved_by(shift: Floats) -> Motion:
    return lambda points, share: points + share * shift


def linear_part(motion: Motion, share: float) -> Floats:
    """(3, 3) of a motion that is the same affine map everywhere."""
    origin = motion(np.zeros((1, 3)), share)
    return np.asarray((motion(np.eye(3), share) - origin).T)


def file_part(model: str) -> str:
    """The name of a model in the names of files."""
    return model.replace(",", "").replace(":", "").replace(" ", "_")
