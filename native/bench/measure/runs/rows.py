# SPDX-License-Identifier: GPL-3.0-or-later
"""A model on a task: what became of the mesh, in numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..inputs.compared import Compared
from ..inputs.mesh import Floats, Mask, midpoint_ends
from ..inputs.poses import Pose
from ..metrics.distortion import area_distortion, edge_strain
from ..metrics.intersections import new_intersections
from ..metrics.sections import thinnest_section, volume
from ..metrics.shape import Surface, largest_distance
from ..metrics.thinness import thinness
from ..metrics.together import asymmetry, parted


def shape_row(task: Compared, now: Floats) -> dict[str, Any]:
    """Shares are of what is at rest, lengths of the diagonal, angles in degrees; None where a task has no such thing.

    Faces and edges that have no free vertex do not count; where the task has a limb, only what is measured of it does.
    """
    pose, (rest, triangles) = task.pose, (task.pose.mesh.positions, task.pose.mesh.triangles)
    surface, free = Surface(pose.mesh), task.limb.is_measured if task.limb else is_free(pose)
    change, has_neighbours = surface.change(now, free), len(surface.edges) > 0
    thin = thinness(triangles, rest, now, free) if task.is_closed else None
    return {
        "volume": volume(now, triangles) / volume(rest, triangles) if task.is_closed else None,
        "section": thinnest_section(task.limb, now) if task.limb else None,
        "thin": thin.thin if thin else None,
        "thin_median": thin.median if thin else None,
        "strain": edge_strain(midpoint_ends(pose.mesh), rest, now, free),
        "area": area_distortion(triangles, rest, now, free),
        "max_deg": change.max_deg if has_neighbours else None,
        "dihedral_rms": change.rms_deg if has_neighbours else None,
        "flips": change.flips if has_neighbours else None,
        "self_intersections": new_intersections(triangles, rest, now, is_free(pose)),
        "off": off_target(pose, now),
        "asymmetry": None if task.mirror is None else asymmetry(rest, now, task.mirror),
        "parted": None if task.beside is None else parted(task.beside, rest, now),
        "stray": None if task.still is None else largest_distance(now[task.still], rest[task.still]),
    }


def is_free(pose: Pose) -> Mask:
    result = np.ones(len(pose.mesh.positions), dtype=bool)
    result[pose.held] = result[pose.moved] = False
    return result


def off_target(pose: Pose, now: Floats) -> float:
    """The largest distance of what is held or moved from where it should be; of a pull only of what is held."""
    of_task = pose.task(1.0)
    return largest_distance(now[of_task.vertices], of_task.targets)
