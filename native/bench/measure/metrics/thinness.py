# SPDX-License-Identifier: GPL-3.0-or-later
"""How thick a closed mesh is inwards of each face, over what it was at rest: Embree casts the rays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from ..inputs.mesh import Floats, Ints, Mask
from .shape import normals

LEAST_REST = 0.01  # what is thinner at rest says nothing: lengths are of the diagonal
START = 1e-5  # of a ray, under its face
NO_HIT = 1e30
PERCENTILE = 2.0


class Thinness(NamedTuple):
    """Shares of the lengths at rest: of the thinnest faces, the 2 % percentile, and the median."""

    thin: float
    median: float


def thinness(triangles: Ints, rest: Floats, now: Floats, free: Mask) -> Thinness | None:
    """Of faces with a free corner whose ray meets something at rest; None where there are none."""
    chosen = np.flatnonzero(free[triangles].any(axis=1)).astype(np.int32)
    before, after = (inward_lengths(p, triangles, chosen) for p in (rest, now))
    is_seen = (before > LEAST_REST) & (before < NO_HIT) & (after < NO_HIT)
    if not is_seen.any():
        return None
    ratios = after[is_seen] / before[is_seen]
    return Thinness(float(np.percentile(ratios, PERCENTILE)), float(np.median(ratios)))


def inward_lengths(positions: Floats, triangles: Ints, faces: Ints) -> Floats:
    """(k,) from the middle of each chosen face along its reversed normal to the next face; NO_HIT where is none."""
    inwards = -normals(positions, triangles[faces])
    starts = positions[triangles[faces]].mean(axis=1) + START * inwards
    scene = EmbreeScene()
    TriangleMesh(scene, positions.astype(np.float32), triangles.astype(np.int32))
    lengths = scene.run(starts.astype(np.float32), inwards.astype(np.float32), query="DISTANCE")
    return np.asarray(lengths, dtype=np.float64) + START
