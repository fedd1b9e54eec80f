# SPDX-License-Identifier: GPL-3.0-or-later
"""What the quality of a deformation is judged on: poses of joints, twists, pulls, thin parts and large moves.

A pose is defined on a base mesh and carried to finer ones by midpoint subdivision: held and moved parts are then the
same pieces of surface at every density, and whatever differs is the solver's doing.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
from arap_deform.core.graph import connected_labels
from scenes.bar import bar
from scenes.creature import DEFAULT_VERTICES, creature, creature_groups

from .mesh import Floats, Ints, Mask, Mesh, make_mesh, midpoint_ends, midpoint_subdivision, triangulated
from .mesh import creature as sample_creature
from .solids import plate
from .tasks import Motion, Task, bend_motion, ends, longest_axis, rotation

X, Y, Z = np.eye(3)
STEPS = 10
NODE_RADIUS = 0.02  # the library's default
PULL_RADIUS = 1.5 * NODE_RADIUS  # of the patch that is pulled


class View(NamedTuple):
    """Where a picture is taken from: the direction to the eye, the middle, and the height that is seen."""

    eye: Sequence[float]
    middle: Sequence[float]
    height: float


class Region(NamedTuple):
    """A ball at rest in which changes are measured."""

    centre: Floats
    radius: float


class Pose(NamedTuple):
    """A mesh and what is asked of it.

    Attributes:
        name: as it appears in tables; also the name of its files.
        mesh: triangles, diagonal 1.
        held, moved: (k,) int32, vertices that stay, and that go where ``motion`` says.
        motion: (k, 3) places at rest and a share in [0, 1] to (k, 3) places.
        steps: in how many steps it is posed from rest.
        region: where changes are measured; None for all that is not constrained.
        patch_radius: above 0 the moved vertex, a single one, stands for the weighted average of the patch around it.
        walls_axis: the axis through a thin part whose opposite walls are to stay apart; None where there is none.
        is_sample: whether the mesh is one of ours: documents show pictures of no others.
        view: of its picture.
    """

    name: str
    mesh: Mesh
    held: Ints
    moved: Ints
    motion: Motion
    view: View
    steps: int = STEPS
    region: Region | None = None
    patch_radius: float = 0.0
    walls_axis: int | None = None
    is_sample: bool = True

    def task(self, share: float) -> Task:
        """The constrained vertices and their targets; without the patch."""
        rest = self.mesh.positions
        moved = np.empty(0, dtype=np.int32) if self.patch_radius else self.moved
        targets = np.concatenate([rest[self.held], self.motion(rest[moved], share)])
        return Task(np.concatenate([self.held, moved]), np.ascontiguousarray(targets))

    def measured(self) -> Mask:
        """(n,) the vertices in the region."""
        rest = self.mesh.positions
        if self.region is not None:
            return np.asarray(np.linalg.norm(rest - self.region.centre, axis=1) < self.region.radius)
        is_free = np.ones(len(rest), dtype=bool)
        is_free[self.held] = False
        return is_free


def finer(pose: Pose) -> Pose:
    """The same pose on the mesh's midpoint subdivision; an edge's midpoint is in a part where both ends are."""
    parents = midpoint_ends(pose.mesh)
    n = len(pose.mesh.positions)

    def with_midpoints(part: Ints) -> Ints:
        is_in = np.zeros(n, dtype=bool)
        is_in[part] = True
        return np.concatenate([part, n + np.flatnonzero(is_in[parents].all(axis=1))]).astype(np.int32)

    mesh = midpoint_subdivision(pose.mesh)._replace(name=pose.mesh.name)
    return pose._replace(mesh=mesh, held=with_midpoints(pose.held), moved=with_midpoints(pose.moved))


def sample_poses() -> Iterator[Pose]:
    """The poses of the sample models, each at its coarsest density, about 10 000 vertices."""
    yield knee()
    yield finer(bar_bend())
    yield finer(bar_twist())
    yield pull("pull, one vertex")
    yield pull("pull, patch", patch_radius=PULL_RADIUS)
    yield wing()
    yield large_move("large move, ten steps", STEPS)
    yield large_move("large move, one step", 1)


def cub_parts(n_vertices: int = DEFAULT_VERTICES) -> tuple[dict[str, Ints], float]:
    """The creature's parts by name, and the length of its metre where its diagonal is 1."""
    model = creature(n_vertices)
    return creature_groups(model), 1.0 / float(np.linalg.norm(np.ptp(model.positions, axis=0)))


def cub_partners(n_vertices: int) -> Ints:
    """(n,) int32, the vertex at the mirror image of each of the creature's through x = 0."""
    partners = creature(n_vertices).mirror
    assert partners is not None
    return partners


def cub() -> Mesh:
    return triangulated(sample_creature(DEFAULT_VERTICES))._replace(name="creature")


def knee() -> Pose:
    """The left front paw bent up by 90 degrees, all but the leg held."""
    mesh, (parts, metre) = cub(), cub_parts()
    x, y, z = mesh.positions.T / metre
    is_leg = (np.hypot(x - 0.195, y + 0.27) < 0.19) & (z < 0.42)
    centre = np.array([0.195, -0.26, 0.25]) * metre
    return Pose(
        "knee",
        mesh,
        np.flatnonzero(~is_leg).astype(np.int32),
        parts["Paw front L"],
        turned(X, centre, -np.pi / 2),
        View((1.0, -0.8, 0.45), list(centre + metre * np.array([0.0, -0.05, 0.03])), 0.58 * metre),
        region=Region(centre, 0.18 * metre),
    )


def straight_bar() -> tuple[Mesh, Ints, Ints, float]:
    """The bar, its lower and upper rows of vertices, and its length."""
    model = bar()
    mesh = triangulated(make_mesh("bar", model.positions, model.quads))
    z = mesh.positions[:, 2]
    length = float(np.ptp(z))
    return mesh, *ends_of(z), length


def ends_of(along: Floats) -> tuple[Ints, Ints]:
    """The vertices within .06 of either end of a mesh, ``along`` (n,) being their places along it from 0 on."""
    share = along / np.ptp(along)
    held, moved = (np.flatnonzero(mask).astype(np.int32) for mask in (share < 0.06, share > 0.94))
    return held, moved


def bar_bend() -> Pose:
    """The upper end goes where an arc of the bar's length takes it, a quarter of a circle."""
    mesh, held, moved, length = straight_bar()

    def along_arc(points: Floats, share: float) -> Floats:
        angle = share * np.pi / 2
        sideways, up = arc(length, angle)
        return np.asarray((points - length * Z) @ rotation(Y, angle).T + sideways * X + up * Z)

    view = View((0.35, -1.0, 0.35), (0.28 * length, 0.0, 0.42 * length), 1.15 * length)
    return Pose("bend", mesh, held, moved, along_arc, view)


def bar_twist() -> Pose:
    """The upper end turned about the bar by 135 degrees."""
    mesh, held, moved, length = straight_bar()
    view = View((0.5, -1.0, 0.35), (0.0, 0.0, 0.5 * length), 1.2 * length)
    return Pose("twist", mesh, held, moved, turned(Z, np.zeros(3), 0.75 * np.pi), view)


def pull(name: str, patch_radius: float = 0.0) -> Pose:
    """A single vertex of the back pulled up by a tenth of the diagonal, the paws held."""
    mesh, (parts, metre) = cub(), cub_parts()
    place = np.array([0.0, 0.10, 0.84]) * metre
    vertex = np.argmin(np.linalg.norm(mesh.positions - place, axis=1))
    return Pose(
        name,
        mesh,
        paws(parts),
        np.array([vertex], dtype=np.int32),
        lambda points, share: points + share * 0.1 * Z,
        View((1.0, -0.35, 0.35), list(place + 0.03 * Z), 0.30),
        region=Region(mesh.positions[vertex], 0.1),
        patch_radius=patch_radius,
    )


def wing() -> Pose:
    """A plate a hundredth as thick as long, bent by 90 degrees along an arc and twisted by 40; its root is held."""
    mesh = make_mesh("wing", *plate((1.0, 0.5, 0.012), (100, 50)))
    length = float(np.ptp(mesh.positions[:, 0]))
    held, moved = ends_of(mesh.positions[:, 0])
    bent = rolled_up(0.0, length, np.pi / 2, twist_rad=np.radians(40))
    view = View((-0.7, -0.8, 0.6), (0.36 * length, 0.0, 0.28 * length), 1.08 * length)
    return Pose("bend and twist", mesh, held, moved, bent, view, walls_axis=2)


def large_move(name: str, steps: int) -> Pose:
    return large_move_of(cub())._replace(name=name, steps=steps)


def large_move_of(mesh: Mesh, n_vertices: int = DEFAULT_VERTICES) -> Pose:
    """The head turned by 70 degrees about an upright axis and moved by a quarter of the diagonal, the paws held.

    ``mesh`` is the creature with ``n_vertices``, in quads or triangles.
    """
    parts, metre = cub_parts(n_vertices)
    turn = turned(Z, np.array([0.0, -0.46, 0.95]) * metre, np.radians(70))
    return Pose(
        "large move",
        mesh,
        paws(parts),
        parts["Head"],
        lambda points, share: turn(points, share) + share * 0.25 * np.array([0.48, -0.36, 0.8]),
        View((1.0, -0.9, 0.3), (0.05, -0.06, 0.38), 0.85),
    )


def paws(parts: dict[str, Ints]) -> Ints:
    return np.concatenate([group for part, group in parts.items() if part.startswith("Paw")])


def named_poses(mesh: Mesh) -> Iterator[Pose]:
    """The poses of a mesh that nothing is known of: a bend along its longest axis, a pull of the middle.

    A slice through a head may take the tips of raised hands along. A tip that is smaller than a node and held exactly
    is a single vertex's case, so what moves are the pieces of the slice that are not.
    """
    mesh = triangulated(mesh)
    axis = longest_axis(mesh)
    view = View((0.6, -1.0, 0.4), list(mesh.positions.mean(axis=0)), 1.2)
    held, moved = ends(mesh, axis)
    moved = wide_pieces(mesh, moved, 2 * NODE_RADIUS)
    yield Pose("bend", mesh, held, moved, bend_motion(mesh, moved), view, is_sample=False)
    middle = np.argsort(mesh.positions[:, axis], kind="stable")[len(mesh.positions) // 2]
    away = mesh.positions[middle] - mesh.positions.mean(axis=0)
    away[axis] = 0.0
    away /= np.linalg.norm(away)
    yield Pose(
        "pull, patch",
        mesh,
        held,
        np.array([middle], dtype=np.int32),
        lambda points, share: points + share * 0.1 * away,
        view,
        region=Region(mesh.positions[middle], 0.1),
        patch_radius=PULL_RADIUS,
        is_sample=False,
    )


def wide_pieces(mesh: Mesh, vertices: Ints, width: float) -> Ints:
    """Those of the vertices (k,) that are in pieces, as their edges connect them, at least so wide, or in the widest.

    A piece is as wide as the diagonal of its box is long.
    """
    n = len(mesh.positions)
    is_in = np.zeros(n, dtype=bool)
    is_in[vertices] = True
    edges = np.concatenate([mesh.triangles[:, [k, k - 1]] for k in range(3)])
    labels = connected_labels(n, *edges[is_in[edges].all(axis=1)].T)
    pieces, piece_of = np.unique(labels[vertices], return_inverse=True)
    low, high = np.full((len(pieces), 3), np.inf), np.full((len(pieces), 3), -np.inf)
    np.minimum.at(low, piece_of, mesh.positions[vertices])
    np.maximum.at(high, piece_of, mesh.positions[vertices])
    widths = np.linalg.norm(high - low, axis=1)
    is_wide = widths >= min(width, widths.max())
    return np.asarray(vertices[is_wide[piece_of]], dtype=np.int32)


def arc(length: float, angle_rad: float) -> tuple[float, float]:
    """Where an arc that turns by an angle ends, across and along the direction in which it starts."""
    half = 0.5 * angle_rad
    return float(length * np.sin(half) * np.sinc(half / np.pi)), float(length * np.sinc(angle_rad / np.pi))


def rolled_up(hinge: float, end: float, angle_rad: float, twist_rad: float = 0.0) -> Motion:
    """What is at x = ``end`` goes where an arc takes it that starts at ``hinge`` along x and turns up by an angle."""

    def motion(points: Floats, share: float) -> Floats:
        up, along = arc(end - hinge, share * angle_rad)
        turn = rotation(Y, -share * angle_rad) @ rotation(X, share * twist_rad)
        return np.asarray((points - end * X) @ turn.T + (hinge + along) * X + up * Z)

    return motion


def turned(axis: Floats, centre: Floats, angle_rad: float) -> Motion:
    """A turn about an axis through a centre."""
    return lambda points, share: (points - centre) @ rotation(axis, share * angle_rad).T + centre
