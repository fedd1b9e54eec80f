# SPDX-License-Identifier: GPL-3.0-or-later
"""What could be attached to a mesh: its children, and what is near it."""

from __future__ import annotations

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.loose.near import Cells
from ..core.transforms import transformed
from ..scene import handle_motion, meshes
from ..scene.points import objects as points
from ..ui.checks import why_not_local
from .problems import owner_of

NEAR = 0.05  # from a vertex of the mesh, as a fraction of the mesh's size
LARGEST = 1.2  # size of what may be attached, in sizes of the mesh: a floor does not
MOST_SAMPLES = 200  # vertices of an object that are looked at


def find_near(host: bpy.types.Object, view_layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
    """Visible meshes and thick curves that are children of the host, or of which the larger part is near it, at rest.

    Attached objects, handles, and what is posed itself are left out.
    """
    depsgraph = bpy.context.evaluated_depsgraph_get()
    surface = transformed(handle_motion.object_matrix(host, depsgraph), meshes.read_rest(host).astype(np.float64))
    size = float(np.linalg.norm(np.ptp(surface, axis=0)))
    cells = Cells(surface, NEAR * size)
    moving = {handle.target for handle in host.arap.handles}
    return [
        other
        for other in view_layer.objects
        if other not in moving
        and _may_be_attached(host, other)
        and (_is_below(host, other) or _is_near(cells, size, _sampled(other, depsgraph)))
    ]


def _may_be_attached(host: bpy.types.Object, other: bpy.types.Object) -> bool:
    if not _may_be_seen(other) or other == host or why_not_local(other) or not other.visible_get():
        return False
    settings = other.arap
    is_own = owner_of(other) is None and not (settings.controls or settings.attachments)
    return is_own and not other.data.is_editmode and points.count(other) > 0


def _may_be_seen(other: bpy.types.Object) -> bool:
    """A curve without thickness is a path or a control, and no thing that is seen."""
    if other.type != "CURVE":
        return points.has_points(other)
    curve = other.data
    return curve.bevel_depth > 0.0 or curve.extrude > 0.0 or curve.bevel_object is not None


def _is_below(host: bpy.types.Object, other: bpy.types.Object) -> bool:
    above = other.parent
    while above is not None and above != host:
        above = above.parent
    return above is not None


def _sampled(other: bpy.types.Object, depsgraph: bpy.types.Depsgraph) -> Floats:
    """(k, 3) vertices in the world, evenly by number, with the corners of the box last."""
    rest = meshes.read_rest(other).astype(np.float64)
    chosen = rest[:: -(-len(rest) // MOST_SAMPLES)]
    corners = np.stack([rest.min(axis=0), rest.max(axis=0)])
    return transformed(meshes.read_matrix(other, depsgraph), np.concatenate([chosen, corners]))


def _is_near(cells: Cells, size: float, samples: Floats) -> bool:
    if not (size > 0.0 and np.linalg.norm(samples[-1] - samples[-2]) <= LARGEST * size):
        return False  # also of an object with a vertex that is not finite
    samples = samples[:-2]
    rows, _, _ = cells.pairs(samples)
    return 2 * len(np.unique(rows)) > len(samples)
