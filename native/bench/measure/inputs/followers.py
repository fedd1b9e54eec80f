# SPDX-License-Identifier: GPL-3.0-or-later
"""Bodies and what they wear: a sleeve on a rod that bends like an elbow, a shirt on a figure, a shell of any size."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .figure import SHIRT_GAP, arm_raised, figure
from .limbs import ROD_LENGTH, Limb, rod_by_bones, rod_mesh
from .mesh import Floats, Ints, Mesh, cut_quads
from .poses import Pose, View, Y, turned

SLEEVE_GAPS = (0.005, 0.015, 0.05)  # of the rod's diameter
SLEEVE_LENGTH = 4.0  # diameters
SLEEVE_AROUND, SLEEVE_ALONG = 60, 100
ELBOW_DEG = 120.0
THICKER = 1.05


class Worn(NamedTuple):
    """A pose of a body, and the follower, whose distance from the body at rest is ``gap``, a share of the diagonal."""

    pose: Pose
    name: str
    follower: Floats
    triangles: Ints
    gap: float


def worn() -> Iterator[Worn]:
    elbow, width = elbow_of_rod()
    for gap in SLEEVE_GAPS:
        places, triangles = tube((0.5 + gap) * width, SLEEVE_LENGTH * width)
        yield Worn(elbow.pose, f"sleeve at {100 * gap:g} % of the limb", places, triangles, gap * width)
    yield shirt()


def elbow_of_rod() -> tuple[Limb, float]:
    """The rod, bent in its middle about y, and its diameter."""
    mesh, width = rod_mesh()
    limb = rod_by_bones("elbow of 120", mesh, width, turned(Y, np.zeros(3), np.radians(ELBOW_DEG)))
    view = View((0.0, -1.0, 0.0), (0.25 * ROD_LENGTH * width, 0.0, 0.0), 0.86 * ROD_LENGTH * width)
    return limb._replace(pose=limb.pose._replace(view=view)), width


def tube(radius: float, length: float) -> tuple[Floats, Ints]:
    """An open cylinder about z, its middle at the origin."""
    angles = 2 * np.pi * np.arange(SLEEVE_AROUND) / SLEEVE_AROUND
    heights = length * (np.arange(SLEEVE_ALONG + 1) / SLEEVE_ALONG - 0.5)
    ring = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = np.concatenate([np.column_stack([ring, np.full(SLEEVE_AROUND, z)]) for z in heights])
    at = np.arange(len(places)).reshape(-1, SLEEVE_AROUND)
    around = np.roll(at, -1, axis=1)
    quads = np.stack([at[:-1], around[:-1], around[1:], at[1:]], axis=-1)
    return places, cut_quads(quads.reshape(-1, 4)).astype(np.int32)


def shirt() -> Worn:
    """The figure's shirt, an arm raised."""
    bare, dressed = figure(is_dressed=False), figure(is_dressed=True)
    pose, _ = arm_raised(bare)
    # Both meshes are centred and scaled to a diagonal of 1, by the same body: the shirt is within its box.
    is_shirt = np.zeros(len(dressed.mesh.positions), dtype=bool)
    is_shirt[dressed.covers[:, 0]] = True
    scale = bare.cube / dressed.cube
    body = dressed.mesh.positions[~is_shirt] * scale
    shift = bare.mesh.positions.mean(axis=0) - body.mean(axis=0)
    faces = dressed.mesh.triangles
    numbers = np.cumsum(is_shirt) - 1
    triangles = numbers[faces[is_shirt[faces].all(axis=1)]].astype(np.int32)
    return Worn(pose, "shirt", dressed.mesh.positions[is_shirt] * scale + shift, triangles, SHIRT_GAP * bare.cube)


def shell(n_vertices: int) -> tuple[Mesh, Floats]:
    """A rod of about so many vertices, and the same one a little thicker, (n, 3)."""
    around = round(np.sqrt(n_vertices / 2))
    mesh, _ = rod_mesh(around, 2 * around)
    return mesh, mesh.positions * [THICKER, THICKER, 1.0]


def bent(rod: Floats, angle_rad: float) -> Floats:
    """A rod about z, its middle at the origin, as an arc in the plane of x and z."""
    radius = float(np.ptp(rod[:, 2])) / angle_rad
    turn, from_centre = rod[:, 2] / radius, radius - rod[:, 0]
    return np.stack([radius - from_centre * np.cos(turn), rod[:, 1], from_centre * np.sin(turn)], axis=1)
