# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the limb that is pulled has its root. No bpy.

Cut the surface at a distance from the pulled piece. L is the length of the cut, A the area that it cuts off, A0 the
whole. L^2 / (A (1 - A / A0)) does not depend on size. For a round patch of a plane or sphere it is 4 pi, wherever the
cut is. Along a limb it falls, as A grows and L does not. Where the limb joins the body, L jumps: that is the root.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Floats, Ints
from ..core.graph import connected_labels
from .coarse import RestMesh, SimplifiedSurface

N_BONES = 5  # the length of a limb is measured along so many straight pieces
N_CUTS = 80  # from the pulled piece to the far end of the mesh
ROUND = 4.0 * np.pi
LIMB = 0.6  # a limb has at most this share of ROUND at its narrowest
JOINT = 1.5  # from there to its root it rises by this factor


class Cut(NamedTuple):
    """``length`` of a cut at a ``distance``; shares of the ``area`` that it cuts off."""

    distance: float
    length: float
    area: float
    whole: float

    @property
    def roundness(self) -> float:
        return self.length**2 / (self.area * (1.0 - self.area / self.whole))


def root_of(coarse: SimplifiedSurface, vertices: Ints, least: float) -> float:
    """The distance of the root of the limb from a piece of the surface; 0 if the piece is on no limb.

    Args:
        vertices: of the mesh, the piece.
        least: a limb is longer than this: so a circle of the mouse that is wider than a finger takes the arm.
    """
    narrowest, at_narrowest, before = np.inf, 0.0, 0.0
    for cut in _cuts(coarse, coarse.distances(vertices)):
        if 2.0 * cut.area > cut.whole:
            return at_narrowest if narrowest <= LIMB * ROUND else 0.0  # a limb is no more than half
        if cut.distance < least or cut.area <= 0.0:
            continue
        if cut.roundness > JOINT * narrowest and narrowest <= LIMB * ROUND:
            return before
        before = cut.distance
        if cut.roundness < narrowest:
            narrowest, at_narrowest = cut.roundness, cut.distance
    return 0.0


def limb_of(fine: RestMesh, vertices: Ints, root: float) -> NDArray[np.bool_]:
    """(n,) which vertices of the mesh go along with a piece of the surface whose limb has its root at this distance.

    Pieces that the limb alone joins to the body go along, too: the foot, if the knee is pulled. What no face joins to
    the limb does not, but see RestMesh.going_along().
    """
    coarse = fine.coarse
    distances = coarse.distances(vertices)
    is_limb: NDArray[np.bool_] = (np.isfinite(distances) & ~_body(coarse, distances, root))[coarse.point_of]
    is_limb[vertices] = True
    return is_limb


def bone_length(fine: RestMesh, vertices: Ints, root: float) -> float:
    """Length of a limb from a piece of the surface to the root: through the middle, so a limb cannot reach farther."""
    coarse = fine.coarse
    distances = coarse.distances(vertices)
    is_limb = distances <= root
    band = np.ceil(distances[is_limb] * (N_BONES / root)).astype(np.int64)
    counts = np.bincount(band)
    sums = np.column_stack([np.bincount(band, coordinates) for coordinates in coarse.points[is_limb].T])
    middles = sums[counts > 0] / counts[counts > 0, None]
    return float(np.linalg.norm(np.diff(middles, axis=0), axis=1).sum())


def border_of(fine: RestMesh, is_limb: NDArray[np.bool_]) -> Ints:
    """(k,) vertices where a limb meets the rest of the mesh."""
    crossing = fine.edges[is_limb[fine.edges[:, 0]] != is_limb[fine.edges[:, 1]]]
    return np.asarray(np.unique(crossing), dtype=np.int32)


def _cuts(coarse: SimplifiedSurface, distances: Floats) -> Iterator[Cut]:
    """Cuts at ascending distances."""
    is_reached = np.isfinite(distances[coarse.triangles]).all(axis=1)
    triangles, areas = coarse.triangles[is_reached], coarse.areas[is_reached]
    whole = float(areas.sum())
    if whole <= 0.0:
        return
    at = distances[triangles]
    farthest = triangles[np.arange(len(triangles)), at.argmax(axis=1)]
    low, middle, high = np.sort(at, axis=1).T
    for distance in high.max() * np.arange(1, N_CUTS) / N_CUTS:
        is_body = _body(coarse, distances, distance)
        is_cut = is_body[farthest] & (low < distance) & (high > distance)
        # Distance grows by one a unit, so a triangle is as wide, across its middle, as twice its area over its span.
        width = 2.0 * areas[is_cut] / (high - low)[is_cut]
        below, above = distance - low[is_cut], high[is_cut] - distance
        to_middle = np.where(distance < middle[is_cut], (middle - low)[is_cut], (high - middle)[is_cut])
        share = np.where(distance < middle[is_cut], below, above) / np.where(to_middle > 0.0, to_middle, 1.0)
        body_area = float(areas @ is_body[triangles].mean(axis=1))
        yield Cut(float(distance), float(width @ share), whole - body_area, whole)


def _body(coarse: SimplifiedSurface, distances: Floats, distance: float) -> NDArray[np.bool_]:
    """(m,) the largest connected piece of what is farther than this."""
    is_beyond = np.isfinite(distances) & (distances > distance)
    labels = connected_labels(len(distances), *coarse.edges[is_beyond[coarse.edges].all(axis=1)].T)
    areas = np.bincount(labels[coarse.triangles[:, 0]], coarse.areas * is_beyond[coarse.triangles].all(axis=1))
    return np.asarray(is_beyond & (labels == areas.argmax())) if len(areas) else is_beyond
