# SPDX-License-Identifier: GPL-3.0-or-later
"""Kinds of meshes that are not one sound, closed, evenly fine surface, each with a pose.

Of most it can be said what should come out: what comes out on a sound mesh, or where a part should be.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .mesh import Floats, Ints, Mesh, make_mesh
from .poses import Pose, View, X, Y, bar_bend, ends_of, finer, pull, rolled_up
from .solids import cubes, finer_where, joined, sheet, welded, with_needles
from .tasks import rotation

HALF = 0.5
FINGERS = (60, 21, 8)  # cubes
BAR = (60, 8, 8)
PEG_STEP = 8  # cubes from peg to peg
NEEDLE_SHARE, NEEDLE_HEIGHT = 0.2, 1e-4  # of the triangles; of their side
N_LOOSE = 500


class Kind(NamedTuple):
    """A kind of mesh.

    Attributes:
        pose: what is asked of it; its name says what is special.
        sound: the same pose on a mesh without that, whose vertices are the first of this one's.
        known: vertices (k,) and where they should be (k, 3).
    """

    pose: Pose
    sound: Pose | None = None
    known: tuple[Ints, Floats] | None = None


def kinds() -> Iterator[Kind]:
    bend, bump = finer(bar_bend()), pull("", patch_radius=0.03)
    yield Kind(cloth())
    yield Kind(leaves())
    yield Kind(pegs())
    yield fingers()
    yield parts()
    yield Kind(slivers(bend), sound=bend)
    yield Kind(loose_vertices(bend), sound=bend)
    yield Kind(dense_half(bump), sound=bump)


def cloth() -> Pose:
    """An open sheet, rolled up by half a turn."""
    return rolled("open sheet", make_mesh("cloth", *sheet((1.0, 0.6), (100, 60))), np.pi)


def leaves() -> Pose:
    """Three sheets with a common border, whose edges have three faces each, bent along it."""
    positions, faces = sheet((1.0, 0.25), (100, 25))
    leaf = positions + 0.125 * Y
    three = joined(*((leaf @ rotation(X, k * 2 * np.pi / 3).T, faces) for k in range(3)))
    return rolled("edges of three faces", make_mesh("leaves", *welded(three)), np.pi / 2)


def pegs() -> Pose:
    """A bar with pegs that are thinner than a node's radius, bent."""
    is_solid = np.zeros((BAR[0], BAR[1], BAR[2] + 3), dtype=bool)
    is_solid[:, :, : BAR[2]] = True
    is_solid[PEG_STEP // 2 :: PEG_STEP, BAR[1] // 2] = True
    return finer(rolled("parts thinner than the radius", make_mesh("pegs", *cubes(is_solid)), np.pi / 2))


def fingers() -> Kind:
    """Two fingers closer than a node's radius; one is bent up, the other and the palm stay."""
    is_solid = np.ones(FINGERS, dtype=bool)
    is_solid[FINGERS[0] // 3 :, FINGERS[1] // 2] = False
    pose = finer(rolled("fingers with a gap", make_mesh("fingers", *cubes(is_solid)), np.pi / 2, hinge=0.4))
    x, y, _ = (pose.mesh.positions / pose.mesh.positions.max(axis=0)).T
    other = np.flatnonzero((x > HALF) & (y < HALF)).astype(np.int32)
    held = np.flatnonzero(x < 1 / 3).astype(np.int32)
    pose = pose._replace(held=held, moved=np.setdiff1d(pose.moved, other))
    return Kind(pose, known=(other, pose.mesh.positions[other]))


def parts() -> Kind:
    """A bar that is bent, one beside it that is only held, a bead smaller than the radius that is led by one side."""
    bar, faces = cubes(np.ones(BAR, dtype=bool))
    bead, bead_faces = cubes(np.ones((1, 1, 1), dtype=bool))
    bead_at = np.array([BAR[0] - 1.0, 0.0, BAR[2] + 1.0])
    mesh = make_mesh("parts", *joined((bar, faces), (bar - (BAR[1] + 0.2) * Y, faces), (bead + bead_at, bead_faces)))
    pose = finer(rolled("several parts", mesh, np.pi / 2))
    x, y, z = pose.mesh.positions.T * (BAR[0] / pose.mesh.positions[:, 0].max())
    is_other, is_bead = y < -0.1, z > BAR[2] + HALF
    is_led = np.where(is_bead, x == x.max(), ~is_other)
    pose = pose._replace(moved=pose.moved[is_led[pose.moved]])
    rest = pose.mesh.positions
    places = np.where(is_bead[:, None], pose.motion(rest, 1.0), rest)
    known = np.flatnonzero(is_other | is_bead).astype(np.int32)
    return Kind(pose, known=(known, places[known]))


def slivers(pose: Pose) -> Pose:
    """With a vertex a hair from a side in every fifth triangle."""
    n = len(pose.mesh.triangles)
    faces = np.random.default_rng(1).permutation(n)[: round(NEEDLE_SHARE * n)].astype(np.int32)
    return pose._replace(name="slivers", mesh=with_needles(pose.mesh, faces, NEEDLE_HEIGHT))


def loose_vertices(pose: Pose) -> Pose:
    """With vertices around it that belong to no face."""
    mesh = pose.mesh
    around = np.random.default_rng(1).uniform(-1.0, 1.0, (N_LOOSE, 3))
    return pose._replace(name="loose vertices", mesh=mesh._replace(positions=np.concatenate([mesh.positions, around])))


def dense_half(pose: Pose) -> Pose:
    """Four times as dense twice, on one side of the moved vertex and near it."""
    mesh = pose.mesh
    centre = mesh.positions[pose.moved[0]]
    for _ in range(2):
        from_centre = mesh.positions[mesh.triangles].mean(axis=1) - centre
        mesh = finer_where(mesh, (np.linalg.norm(from_centre, axis=1) < 0.1) & (from_centre[:, 0] > 0.0))
    return pose._replace(name="uneven density", mesh=mesh)


def rolled(name: str, mesh: Mesh, angle_rad: float, hinge: float = 0.0) -> Pose:
    """Held where x is least; what is at its other end goes where an arc takes it. ``hinge`` is a part of the length."""
    x = mesh.positions[:, 0]
    length = float(np.ptp(x))
    held, moved = ends_of(x)
    middle = (0.45 * length, float(mesh.positions[:, 1].mean()), 0.25 * length)
    view = View((-0.7, -1.0, 0.6), middle, 1.3 * length)
    return Pose(name, mesh, held, moved, rolled_up(hinge * length, length, angle_rad), view)
