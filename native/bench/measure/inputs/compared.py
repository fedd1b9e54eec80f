# SPDX-License-Identifier: GPL-3.0-or-later
"""The tasks that all models of deformation are compared on: some vertices stay, some move, from rest in even steps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .limbs import Limb, creature_legs, rods
from .mesh import Floats, make_mesh
from .poses import Pose, View, X, Y, Z, bar_bend, bar_twist, cub, large_move_of
from .solids import sheet
from .tasks import Motion

PLANE_CELLS, PLANE_HELD, PLANE_MOVED, PLANE_HEIGHT = 60, 0.46, 0.06, 0.3  # in widths, from the middle
LIMB_TASKS = 2  # of the rods: those that are held by vertices
ROD_VIEW = View((0.0, -1.0, 0.0), (0.22, 0.0, -0.1), 1.05)


class Compared(NamedTuple):
    """A task.

    Attributes:
        pose: of which the tables have a row for each model.
        limb: what its sections are measured with; None where it has none.
        is_closed: whether it has a volume.
    """

    pose: Pose
    limb: Limb | None = None
    is_closed: bool = True


def tasks() -> Iterator[Compared]:
    yield Compared(plane(), is_closed=False)
    for limb in list(rods())[:LIMB_TASKS]:
        yield Compared(limb.pose._replace(view=ROD_VIEW), limb)
    yield Compared(bar_bend()._replace(name="bend by 90"))
    yield Compared(bar_twist()._replace(name="twist by 135"))
    for limb in creature_legs():
        yield Compared(limb.pose, limb)
    yield Compared(large_move_of(cub())._replace(name="head turned and moved"))
    yield Compared(translation())


def plane() -> Pose:
    """A square sheet, its border held, its middle pulled up without a turn."""
    mesh = make_mesh("plane", *sheet((1.0, 1.0), (PLANE_CELLS, PLANE_CELLS)))
    width = float(np.ptp(mesh.positions[:, 0]))
    away = np.abs(mesh.positions - [0.5 * width, 0.0, 0.0]).max(axis=1) / width
    held, moved = (np.flatnonzero(m).astype(np.int32) for m in (away > PLANE_HELD, away < PLANE_MOVED))
    view = View((0.4, -1.0, 0.6), (0.5 * width, 0.0, 0.3 * PLANE_HEIGHT * width), 1.5 * width)
    return Pose("pulled up", mesh, held, moved, moved_by(PLANE_HEIGHT * width * Z), view)


def translation() -> Pose:
    """The creature's head moved sideways without a turn, the paws held."""
    pose = large_move_of(cub())
    return pose._replace(name="head moved only", motion=moved_by(0.15 * X - 0.1 * Y))


def moved_by(shift: Floats) -> Motion:
    return lambda points, share: points + share * shift


def linear_part(motion: Motion, share: float) -> Floats:
    """(3, 3) of a motion that is the same affine map everywhere."""
    origin = motion(np.zeros((1, 3)), share)
    return np.asarray((motion(np.eye(3), share) - origin).T)


def file_part(model: str) -> str:
    """The name of a model in the names of files."""
    return model.replace(",", "").replace(" ", "_")
