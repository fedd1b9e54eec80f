# SPDX-License-Identifier: GPL-3.0-or-later
"""Limbs that are twisted and bent, for what a surface does beside a solid: a rod, a leg, two fingers.

Each is a pose of six steps with what is measured of it: the sections between two places and the part of the surface
that is away from handles.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .mesh import Floats, Mask, Mesh, load_off, make_mesh, mesh_files
from .poses import Pose, View, X, Y, Z, arc, cub_parts, knee, turned
from .solids import cubes, rod
from .tasks import Motion, rotation

LIMB_STEPS = 6
ROD_LENGTH, ROD_AROUND, ROD_ALONG = 6.0, 48, 92
ROD_HELD = 0.5  # at each end, in diameters
ROD_MEASURED = 2.0  # to both sides of the middle
BONE_END = 2.9
FINGER, GAP, PALM, FINGER_CELLS = 0.5, 0.05, 0.6, 10
LEG_WIDTH = 0.22  # of the creature, in metres
ACROSS = 4  # cubes
LEG_MESH = "armadillo_43k"
LEG_CUBE = 0.02


class Limb(NamedTuple):
    """A pose of a limb, and what is measured of it.

    Attributes:
        pose: with the vertices held and moved.
        low, high: (3,) between these are the sections, planes across the line from one to the other.
        is_limb: (n,) the vertices of the limb; sections cut only faces of these.
        is_measured: (n,) the vertices away from handles.
        cube_size: of the lattice, as a fraction of the diagonal; 0 is automatic.
        weights: (n,) of the second bone, for linear skinning; None where no skinning is compared.
        bones: (s, 2, 3) head and tail at rest; the last one moves as ``pose.motion`` says. None: vertices are held.
        tilt_deg: by how much its picture is turned about y.
    """

    pose: Pose
    low: Floats
    high: Floats
    is_limb: Mask
    is_measured: Mask
    cube_size: float
    weights: Floats | None = None
    bones: Floats | None = None
    tilt_deg: float = 0.0


def rods() -> Iterator[Limb]:
    """The rod held by its ends, then by two bones that meet in its middle."""
    mesh, width = rod_mesh()
    length = ROD_LENGTH * width
    twist = turned(Z, np.zeros(3), np.pi)
    yield rod_by_ends("twist by 180", mesh, width, twist)
    yield rod_by_ends("bend by 120", mesh, width, along_arc(length - 2 * ROD_HELD * width, np.radians(120)))
    yield rod_by_bones("two bones, twist by 180", mesh, width, twist)._replace(tilt_deg=45.0)
    elbow = rod_by_bones("two bones, elbow of 120", mesh, width, turned(Y, np.zeros(3), np.radians(120)))
    view = View((0.0, -1.0, 0.0), (0.0, 0.0, -1.2 * width), 0.68 * length)
    yield elbow._replace(tilt_deg=30.0, pose=elbow.pose._replace(view=view))


def rod_mesh(around: int = ROD_AROUND, along: int = ROD_ALONG) -> tuple[Mesh, float]:
    """The rod, and its diameter where its diagonal is 1."""
    positions, faces = rod(ROD_LENGTH, around, along)
    width = 1.0 / float(np.linalg.norm(np.ptp(positions, axis=0)))
    return make_mesh("rod", positions, faces), width


def along_arc(length: float, angle_rad: float) -> Motion:
    """What is above a free length about the origin goes where an arc of that length takes it."""
    end = 0.5 * length * Z

    def motion(points: Floats, share: float) -> Floats:
        sideways, up = arc(length, share * angle_rad)
        turn = rotation(Y, share * angle_rad)
        return np.asarray((points - end) @ turn.T - end + sideways * X + up * Z)

    return motion


def rod_by_ends(name: str, mesh: Mesh, width: float, motion: Motion) -> Limb:
    """Half a diameter at each end held hard, the upper end moved."""
    end = (0.5 * ROD_LENGTH - ROD_HELD) * width + 1e-9
    return _rod(name, mesh, width, end, motion)


def rod_by_bones(name: str, mesh: Mesh, width: float, motion: Motion) -> Limb:
    """Two bones that meet in the middle.

    The surface, which takes no bones, is held and moved from half a diameter beside the joint on. The weights for
    skinning grow linearly between these places.
    """
    joint, end = np.zeros(3), BONE_END * width * Z
    weights = np.clip(mesh.positions[:, 2] / width + 0.5, 0.0, 1.0)
    limb = _rod(name, mesh, width, 0.5 * width, motion)
    return limb._replace(weights=weights, bones=np.array([[-end, joint], [joint, end]]))


def _rod(name: str, mesh: Mesh, width: float, free: float, motion: Motion) -> Limb:
    z = mesh.positions[:, 2]
    held, moved = (np.flatnonzero(mask).astype(np.int32) for mask in (z < -free, z > free))
    measured = ROD_MEASURED * width
    view = View((0.0, -1.0, 0.0), (0.0, 0.0, 0.0), 0.86 * ROD_LENGTH * width)
    pose = Pose(name, mesh, held, moved, motion, view, steps=LIMB_STEPS)
    everywhere = np.ones(len(z), dtype=bool)
    return Limb(pose, -measured * Z, measured * Z, everywhere, np.abs(z) < measured, width / ACROSS)


def creature_legs() -> Iterator[Limb]:
    """The creature's left front paw, bent by 90 degrees about the knee, and twisted by 120; all but the leg is held."""
    bent, (_, metre) = knee(), cub_parts()
    centre = np.array([0.195, -0.26, 0.25]) * metre
    x, y, z = bent.mesh.positions.T / metre
    is_leg = (np.hypot(x - 0.195, y + 0.27) < 0.19) & (z < 0.42)
    weights = np.where(is_leg, np.clip((0.25 - z) / LEG_WIDTH + 0.5, 0.0, 1.0), 0.0)
    low, high = (centre + metre * (height - 0.25) * Z for height in (0.13, 0.33))
    near = is_leg & (z > 0.13) & (z < 0.36)
    twisted = bent._replace(name="paw, twist by 120", motion=turned(Z, centre, np.radians(120)))
    for pose in (bent._replace(name="paw, knee of 90"), twisted):
        yield Limb(pose._replace(steps=LIMB_STEPS), low, high, is_leg, near, 0.0, weights)


def legs(setting: str) -> Iterator[Limb]:
    """A leg of the figure, if it is among the meshes that a setting like ARAP_BENCH_MESHES names.

    The foot is moved hard: turned by 180 degrees about the leg, and by 120 about the knee. All above the leg is held.
    """
    found = [path for path in mesh_files(setting) if path.stem == LEG_MESH]
    foot, middle, hip = np.array([[-0.112, -0.31, -0.075], [-0.118, -0.235, -0.060], [-0.112, -0.15, -0.045]])
    for path in found[:1]:
        mesh = load_off(path)
        yield leg("leg, twist by 180", mesh, foot, hip, turned(hip - foot, foot, np.pi))
        yield leg("leg, knee of 120", mesh, foot, hip, turned(X, middle, np.radians(120)))


def leg(name: str, mesh: Mesh, foot: Floats, hip: Floats, motion: Motion) -> Limb:
    """What is measured is between foot and hip; what is moved is 2 % below, what is held 2 % above."""
    x, y, _ = mesh.positions.T
    is_leg = (x < -0.04) & (y < hip[1] + 0.02)
    held, moved = (np.flatnonzero(mask).astype(np.int32) for mask in (~is_leg, is_leg & (y < foot[1] - 0.02)))
    is_measured = is_leg & (y > foot[1]) & (y < hip[1])
    view = View((-1.0, 0.2, 0.6), list(0.5 * (foot + hip)), 0.45)
    pose = Pose(name, mesh, held, moved, motion, view, steps=LIMB_STEPS, is_sample=False)
    return Limb(pose, foot, hip, is_leg, is_measured, LEG_CUBE)


def fingers() -> tuple[Pose, Mask, float]:
    """Two fingers on a palm, the tip of one turned by 60 and 25 degrees; the other one's vertices, a finger's width."""
    side = FINGER / FINGER_CELLS
    height = PALM + 4 * FINGER
    is_solid = np.ones((2 * FINGER_CELLS + round(GAP / side), FINGER_CELLS, round(height / side)), dtype=bool)
    is_solid[FINGER_CELLS:-FINGER_CELLS, :, round(PALM / side) :] = False
    positions, faces = cubes(is_solid, side)
    positions = positions - [FINGER + 0.5 * GAP, 0.5 * FINGER, 0.0]
    mesh = make_mesh("fingers", positions, faces)
    scale = 1.0 / float(np.linalg.norm(np.ptp(positions, axis=0)))
    x, _, z = positions.T
    held, moved = (np.flatnonzero(m).astype(np.int32) for m in (z < 0.3, (x < 0) & (z > height - 0.3 + 1e-9)))
    centre = scale * np.array([-0.5 * (FINGER + GAP), 0.0, PALM])

    def motion(points: Floats, share: float) -> Floats:
        turn = rotation(X, -share * np.radians(60)) @ rotation(Y, -share * np.radians(25))
        return np.asarray((points - centre) @ turn.T + centre)

    view = View((0.3, -1.0, 0.3), (0.0, 0.0, 0.5), 1.2)
    pose = Pose("fingers", mesh, held, moved, motion, view, steps=LIMB_STEPS)
    return pose, np.asarray((x > 0) & (z > PALM)), FINGER * scale


def second_bone_targets(bones: Floats, motion: Motion, share: float) -> Floats:
    """(4 s, 3) targets of bones at rest, but for the last, which moves: four places of each, see set_constraints()."""
    heads, lengths = bones[:, 0], np.linalg.norm(bones[:, 1] - bones[:, 0], axis=1)
    corners = np.concatenate([np.zeros((1, 3)), np.eye(3)])
    places = heads[:, None] + lengths[:, None, None] * corners
    places[-1] = motion(places[-1], share)
    return np.ascontiguousarray(places.reshape(-1, 3))
