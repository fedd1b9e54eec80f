# SPDX-License-Identifier: GPL-3.0-or-later
"""A figure that stands with its arms spread, bare or in a shirt, an open sheet of its own."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scenes.quad_mesh import QuadMesh, vertex_normals
from scenes.subdivision import catmull_clark

from .bones import Bone, named_bones
from .mesh import Floats, Ints, Mask, Mesh, cut_quads, make_mesh
from .poses import Pose, View, Y, turned
from .solids import cube_quads, joined

# In cubes: x across, y to the back, z up; the middle of the figure is at x = 0.
BOXES = (
    ((-3, 3), (0, 4), (8, 18)),  # trunk
    ((-3, -1), (1, 3), (0, 8)), ((1, 3), (1, 3), (0, 8)),  # legs
    ((-11, -3), (1, 3), (15, 17)), ((3, 11), (1, 3), (15, 17)),  # arms
    ((-1, 1), (1, 3), (18, 19)), ((-2, 2), (0, 4), (19, 23)),  # neck and head
)  # fmt: skip
REACH, DEPTH, HEIGHT = 11, 4, 23
SHOULDER = (2.6, 2.0, 16.0)
SHIRT_LOW, SHIRT_HIGH, SLEEVE, SHIRT_GAP = 9.0, 17.6, 7.0, 0.12
RAISE = np.radians(70)
FOREARM, TORSO, LEGS = 7.9, 1.9, 12.0  # what is moved, and what is held, by x and by z


class Figure(NamedTuple):
    """The mesh, the length of a cube in it, and of each vertex of the shirt the vertex that it covers: (k, 2)."""

    mesh: Mesh
    cube: float
    covers: Ints


def figure(is_dressed: bool) -> Figure:
    is_solid = np.zeros((2 * REACH, DEPTH, HEIGHT), dtype=bool)
    for (x0, x1), (y0, y1), (z0, z1) in BOXES:
        is_solid[x0 + REACH : x1 + REACH, y0:y1, z0:z1] = True
    places, quads = cube_quads(is_solid)
    body = catmull_clark(catmull_clark(QuadMesh(places - [REACH, 0.0, 0.0], quads)))
    surface = body.positions, cut_quads(body.quads)
    covered: Ints = np.empty(0, dtype=np.int32)
    if is_dressed:
        shirt, faces, covered = _shirt(body)
        surface = joined(surface, (shirt, faces))
    mesh = make_mesh("dressed figure" if is_dressed else "figure", *surface)
    cube = float(np.ptp(mesh.positions[:, 2]) / np.ptp(surface[0][:, 2]))
    own = len(body.positions) + np.arange(len(covered))
    return Figure(mesh, cube, np.stack([own, covered], axis=1).astype(np.int32))


def _shirt(body: QuadMesh) -> tuple[Floats, Ints, Ints]:
    """The body's faces under the shirt, moved outwards, and the body's vertex under each vertex of it."""
    x, _, z = body.positions.T
    is_neck = (z > SHIRT_HIGH) & (np.abs(x) < SHOULDER[0])
    is_under = (z > SHIRT_LOW) & (np.abs(x) < SLEEVE) & ~is_neck
    quads = body.quads[is_under[body.quads].all(axis=1)]
    covered, numbers = np.unique(quads, return_inverse=True)
    places = body.positions[covered] + SHIRT_GAP * vertex_normals(body)[covered]
    return places, cut_quads(numbers.reshape(-1, 4)), covered.astype(np.int32)


def arm_raised(made: Figure) -> tuple[Pose, tuple[Bone, ...]]:
    """The left forearm turned up about the shoulder; of the body all but this arm is held, of a shirt nothing."""
    mesh, cube = made.mesh, made.cube
    x, _, z = mesh.positions.T / cube
    is_body: Mask = np.ones(len(x), dtype=bool)
    is_body[made.covers[:, 0]] = False
    held, moved = (np.flatnonzero(is_body & m).astype(np.int32) for m in ((x < TORSO) | (z < LEGS), x > FOREARM))
    raised = turned(Y, cube * np.array(SHOULDER), -RAISE)
    middle = cube * np.array([4.0, 2.0, 16.0])
    pose = Pose("arm raised", mesh, held, moved, raised, View((0.3, -1.0, 0.25), list(middle), 0.68), steps=6)
    bones = named_bones(
        {
            "spine": ((0, 2, 8.5), (0, 2, 17.5)),
            "head": ((0, 2, 18), (0, 2, 22)),
            "leg L": ((2, 2, 8), (2, 2, 0.5)),
            "leg R": ((-2, 2, 8), (-2, 2, 0.5)),
            "upper arm L": (SHOULDER, (7, 2, 16)),
            "forearm L": ((7, 2, 16), (10.5, 2, 16)),
            "arm R": ((-SHOULDER[0], 2, 16), (-10.5, 2, 16)),
        },
        cube,
        {"upper arm L": raised, "forearm L": raised},
    )
    return pose, bones
