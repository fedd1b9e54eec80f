# SPDX-License-Identifier: GPL-3.0-or-later
"""What the meshes are asked to do: some vertices held, some moved, all of them at full strength."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from .mesh import Floats, Ints, Mesh

HELD, MOVED = 0.05, 0.02
Motion = Callable[[Floats, float], Floats]  # places (k, 3) at rest and a share in [0, 1] of the way, to places


class Task(NamedTuple):
    """Constrained vertices (k,) int32 and where they go, (k, 3) float64."""

    vertices: Ints
    targets: Floats


def bend(mesh: Mesh) -> Task:
    """The lowest 5 % along the longest axis held, the top 2 % moved as ``bend_motion`` says."""
    held, moved = ends(mesh, longest_axis(mesh))
    return _task(mesh, held, moved, bend_motion(mesh, moved)(mesh.positions[moved], 1.0))


def bend_motion(mesh: Mesh, moved: Ints) -> Motion:
    """A turn by 90 degrees about an oblique axis through the centroid of ``moved``, and a move.

    The move is by .35 and .15 of the mesh's length sideways and .15 down.
    """
    axis = longest_axis(mesh)
    length = float(np.ptp(mesh.positions[:, axis]))
    direction = np.roll(np.array([0.2, 1.0, 0.7]), axis)
    shift = length * np.roll(np.array([-0.15, 0.35, 0.15]), axis)
    centre = mesh.positions[moved].mean(axis=0)

    def motion(points: Floats, share: float) -> Floats:
        return np.asarray((points - centre) @ rotation(direction, share * np.pi / 2).T + centre + share * shift)

    return motion


def longest_axis(mesh: Mesh) -> int:
    return int(np.argmax(np.ptp(mesh.positions, axis=0)))


def displacement(mesh: Mesh, share: float) -> Task:
    """The lowest 5 % in y held; of the top 2 % ``share`` of a turn by 60 degrees and a move by .3 of the diagonal.

    The turn is about z through the bounding box's centre, the move along (1, 1, 1).
    """
    held, moved = ends(mesh, 1)
    centre = 0.5 * (mesh.positions.max(axis=0) + mesh.positions.min(axis=0))
    turn = rotation(np.array([0.0, 0.0, 1.0]), share * np.pi / 3)
    shift = share * 0.3 / np.sqrt(3.0)
    return _task(mesh, held, moved, (mesh.positions[moved] - centre) @ turn.T + centre + shift)


def ends(mesh: Mesh, axis: int) -> tuple[Ints, Ints]:
    """The lowest 5 % and the top 2 % of the vertices along an axis."""
    n = len(mesh.positions)
    order = np.argsort(mesh.positions[:, axis], kind="stable").astype(np.int32)
    return order[: int(np.ceil(HELD * n))], order[n - int(np.ceil(MOVED * n)) :]


def rotation(axis: Floats, angle_rad: float) -> Floats:
    """(3, 3) turn about an axis, of any length."""
    x, y, z = axis / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + np.sin(angle_rad) * cross + (1.0 - np.cos(angle_rad)) * cross @ cross)


def write_task(path: Path, mesh: Mesh, task: Task) -> None:
    """Writes both for the programs that measure.

    Four int64: the numbers of vertices, corners, faces, constrained vertices. Then the arrays, C-ordered and little
    endian: positions (float64), corner_vertices, face_sizes, constrained vertices (int32), targets (float64).
    """
    counts = [len(mesh.positions), len(mesh.corner_vertices), len(mesh.face_sizes), len(task.vertices)]
    with path.open("wb") as file:
        for array in (
            np.array(counts, dtype="<i8"),
            mesh.positions.astype("<f8"),
            mesh.corner_vertices.astype("<i4"),
            mesh.face_sizes.astype("<i4"),
            task.vertices.astype("<i4"),
            task.targets.astype("<f8"),
        ):
            file.write(array.tobytes())


def read_task(path: Path) -> tuple[Mesh, Task]:
    """What write_task wrote; the mesh takes the file's name."""
    with path.open("rb") as file:
        n, c, f, k = np.fromfile(file, "<i8", 4)
        positions = np.fromfile(file, "<f8", 3 * n).reshape(n, 3)
        mesh = Mesh(path.stem, positions, np.fromfile(file, "<i4", c), np.fromfile(file, "<i4", f))
        return mesh, Task(np.fromfile(file, "<i4", k), np.fromfile(file, "<f8", 3 * k).reshape(k, 3))


def _task(mesh: Mesh, held: Ints, moved: Ints, moved_to: Floats) -> Task:
    targets = np.concatenate([mesh.positions[held], moved_to])
    return Task(np.concatenate([held, moved]), np.ascontiguousarray(targets))
