# SPDX-License-Identifier: GPL-3.0-or-later
"""Bones that do a task: what a person draws for models that have bones, and how they go."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from .mesh import Floats
from .poses import X, Y, Z, arc, cub_parts
from .tasks import Motion, rotation

N_MIDDLE = 3  # bones between the held and the moved end of a rod
LEGS = {"front": -0.26, "hind": 0.20}  # their y, in metres
LEG_X, HIP, KNEE, SOLE = 0.2, 0.42, 0.25, 0.03
Between = Callable[[float, float], Motion]  # of what lies between two shares of a length


class Bone(NamedTuple):
    """A bone at rest, (3,) each, and the rigid motion that it makes."""

    head: Floats
    tail: Floats
    motion: Motion


def still(points: Floats, _: float) -> Floats:
    """The motion of what stays."""
    return points


def rod_bones(low: Floats, high: Floats, ends: tuple[float, float], between: Between, last: Motion) -> tuple[Bone, ...]:
    """A chain from low to high: a bone that stays, N_MIDDLE that share the motion, and one that makes all of it.

    ``ends`` are the shares of the length where the first ends and the last begins.
    """
    shares = [0.0, *np.linspace(*ends, N_MIDDLE + 1), 1.0]
    motions = [still, *(between(a, b) for a, b in pairwise(shares[1:-1])), last]
    joints = [low + share * (high - low) for share in shares]
    return tuple(Bone(*joint, motion) for joint, motion in zip(pairwise(joints), motions, strict=True))


def twist_between(axis: Floats, centre: Floats, angle_rad: float, ends: tuple[float, float]) -> Between:
    """A turn about the chain that grows evenly from one end to the other."""

    def between(a: float, b: float) -> Motion:
        angle = angle_rad * (0.5 * (a + b) - ends[0]) / (ends[1] - ends[0])
        return lambda points, share: (points - centre) @ rotation(axis, share * angle).T + centre

    return between


def arc_between(start: Floats, length: float, angle_rad: float, low: float = 0.0, high: float = 1.0) -> Between:
    """Along an arc of a length from ``start``, that leaves it along z and turns towards x by an angle.

    ``low`` and ``high`` are the shares of the chain where the arc begins and ends.
    """

    def between(a: float, b: float) -> Motion:
        at, turn_at = ((share - low) / (high - low) for share in (a, 0.5 * (a + b)))
        head = start + at * length * Z

        def motion(points: Floats, share: float) -> Floats:
            sideways, up = arc(at * length, at * share * angle_rad)
            turn = rotation(Y, turn_at * share * angle_rad)
            return np.asarray((points - head) @ turn.T + start + sideways * X + up * Z)

        return motion

    return between


def cub_bones(moved: dict[str, Motion]) -> tuple[Bone, ...]:
    """The creature's spine, tail, head and legs; those that are named make a motion."""
    _, metre = cub_parts()
    places = {
        "spine": ((0.0, 0.42, 0.60), (0.0, -0.35, 0.65)),
        "tail": ((0.0, 0.55, 0.67), (0.0, 0.93, 1.20)),
        "head": ((0.0, -0.46, 0.95), (0.0, -1.00, 1.00)),
    }
    for end, y in LEGS.items():
        for side, x in (("L", LEG_X), ("R", -LEG_X)):
            hip, knee, sole = ((x, y, z) for z in (HIP, KNEE, SOLE))
            places |= {f"upper {end} {side}": (hip, knee), f"lower {end} {side}": (knee, sole)}
    return named_bones(places, metre, moved)


def named_bones(
    places: Mapping[str, tuple[Sequence[float], Sequence[float]]], scale: float, moved: dict[str, Motion]
) -> tuple[Bone, ...]:
    """Bones from heads and tails times a scale, all still but those that are named."""
    return tuple(
        Bone(scale * np.array(head), scale * np.array(tail), moved.get(name, still))
        for name, (head, tail) in places.items()
    )
