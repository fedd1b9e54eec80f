# SPDX-License-Identifier: GPL-3.0-or-later
"""What should stay alike: both halves of a mirror-symmetric task, and what lies side by side."""

from __future__ import annotations

import numpy as np

from ..inputs.mesh import Floats, Ints
from .shape import largest_distance

PLACE = 1e-6  # vertices nearer than that are at the same place


def asymmetry(rest: Floats, now: Floats, axis: int) -> float:
    """How far a vertex is at most from the mirror image of its partner, across the middle of the mesh at rest.

    Vertices without a partner at rest do not count.
    """
    centre = 0.5 * (rest[:, axis].min() + rest[:, axis].max())
    own, partners = mirror_pairs(rest, mirrored(rest, axis, centre))
    return largest_distance(now[own], mirrored(now[partners], axis, centre))


def mirrored(points: Floats, axis: int, centre: float) -> Floats:
    image = points.copy()
    image[:, axis] = 2.0 * centre - image[:, axis]
    return image


def mirror_pairs(points: Floats, images: Floats) -> tuple[Ints, Ints]:
    """Indices (k,), (k,) of points (n, 3), and of those whose images are at the same places."""
    both = np.rint(np.concatenate([points, images]) / PLACE)
    # A place at the border of two cells of the rounding has no partner then: these are few, and only seen in halves.
    _, place = np.unique(both, axis=0, return_inverse=True)
    place = place.reshape(-1)
    of_image = np.full(int(place.max()) + 1, -1)
    of_image[place[len(points) :]] = np.arange(len(points))
    partners = of_image[place[: len(points)]]
    own = np.flatnonzero(partners >= 0)
    return own.astype(np.int32), partners[own].astype(np.int32)


def parted(pairs: Ints, rest: Floats, now: Floats) -> float:
    """By how much the distance of vertices (k, 2) changed at most."""
    before, after = (np.linalg.norm(p[pairs[:, 0]] - p[pairs[:, 1]], axis=1) for p in (rest, now))
    return float(np.abs(after - before).max())
