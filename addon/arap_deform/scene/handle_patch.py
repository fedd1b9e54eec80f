# SPDX-License-Identifier: GPL-3.0-or-later
"""What point handles hold before there is a session, and how the mesh stays when a pin or handle is added."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import native
from ..core.arrays import Float32s, Floats, Ints
from ..core.local_patch import local_patch, neighbourhood
from ..core.patches import (
    Point,
    Surface,
    diagonal_of,
    held_by_themselves,
    points_of,
    without,
    without_points,
)
from ..core.staying import Moved, staying_targets
from ..core.targets import HandleSpec, Patch
from ..core.transforms import transformed
from . import handle_motion, meshes
from .inputs import enabled_entries, hold_of, settings_of, spec_of

if TYPE_CHECKING:
    from ..props.handles import ArapHandle, ArapPin

    Entry = ArapPin | ArapHandle

AT_PLACE = 1e-5  # a shape that is this near to that at rest is the one at rest, as a fraction of the diagonal


class _Holder:
    """What the enabled pins and handles hold."""

    def __init__(
        self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, entries: Sequence[Entry], use_nodes: bool | None
    ) -> None:
        """``use_nodes``: see versions.read_group_weights()."""
        self._obj, self._use_nodes = obj, use_nodes
        self.entries = [entry for entry in entries if hold_of(entry).group in obj.vertex_groups]
        self.mesh = meshes.read_mesh(obj)
        self.stretch = meshes.read_stretch(obj, depsgraph)
        self._settings = settings_of(obj)
        self.has_points = self._settings.has_radius and not native.problem()
        seen = self.mesh.rest_positions @ self.stretch.T
        self.surface = Surface.of(seen, self.mesh.corner_vertices, self.mesh.face_sizes, self._settings.rigidity_radius)

    @cached_property
    def specs(self) -> list[HandleSpec]:
        """Of the entries."""
        names = [hold_of(entry).group for entry in self.entries]
        weights = meshes.read_weights(self._obj, sorted(set(names)), use_nodes=self._use_nodes)
        rest = self.mesh.rest_positions
        return [spec_of(e, weights[name], rest) for e, name in zip(self.entries, names, strict=True)]

    def points(self, specs: Sequence[HandleSpec]) -> dict[int, list[Point]]:
        """The points among them, by index."""
        found: dict[int, list[Point]] = {}
        for point in points_of(specs, self.surface) if self.has_points else ():
            found.setdefault(point.handle, []).append(point)
        return found

    def is_held(self, specs: Sequence[HandleSpec], points: Mapping[int, Sequence[Point]]) -> NDArray[np.bool_]:
        """(n,) see held_by_themselves()."""
        of_points = {i: [point.vertices for point in of_handle] for i, of_handle in points.items()}
        return held_by_themselves(specs, of_points, len(self.surface.seen))

    def patches(self, points: Sequence[Point], is_held: NDArray[np.bool_]) -> list[Patch]:
        """Of these points, without vertices that are held by themselves."""
        found = (self.patch(point) for point in points)
        left = (without(patch, is_held) for patch in found if patch is not None)
        return [patch for patch in left if patch is not None]

    def set_shape(self, index: int, vertices: Ints, targets: Floats, matrix: Floats) -> None:
        """Lets an entry hold the vertices so that it pulls them to (k, 3) ``targets`` where it is now."""
        back: Floats = np.asarray(np.linalg.inv(matrix))
        offsets = transformed(back, targets) - self.mesh.rest_positions[vertices]
        if np.abs(offsets @ self.stretch.T).max() > AT_PLACE * diagonal_of(self.surface.seen):
            self.entries[index].set_shape(vertices, offsets, len(self.surface.seen))

    def patch(self, point: Point) -> Patch | None:
        """Without a look at what other handles hold."""
        mesh, seen = self.mesh, self.surface.seen
        part = neighbourhood(seen, mesh.corner_vertices, mesh.face_sizes, point.vertices, point.reach)
        return local_patch(
            native.load(), mesh.rest_positions, part, point.vertices, point.reach, self.stretch, self._settings
        )


def find_patch(
    obj: bpy.types.Object,
    depsgraph: bpy.types.Depsgraph,
    vertices: Ints,
    besides: ArapHandle | None = None,
    *,
    use_nodes: bool | None = None,
) -> Patch | None:
    """The patch that a handle of these vertices would hold if it is not exact. None: it holds the vertices, or pieces.

    Args:
        depsgraph: for its scale.
        vertices: (k,), all of weight 1.
        besides: the handle of these vertices, if there is one already.
        use_nodes: see versions.read_group_weights().
    """
    holder = _Holder(obj, depsgraph, [entry for entry in enabled_entries(obj) if entry != besides], use_nodes)
    spec = HandleSpec("", vertices, np.ones(len(vertices)), is_exact=False)
    if 0 not in holder.points([spec]):  # quick, and most handles are none
        return None
    found = holder.points([spec, *holder.specs]).get(0, ())
    return holder.patch(found[0]) if len(found) == 1 and len(found[0].vertices) == len(vertices) else None


def stay(obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, *added: Entry, use_nodes: bool | None = None) -> None:
    """Lets new pins and handles hold what is shown, so that the mesh stays where it is when it is solved again.

    The new ones hold their vertices as they are shown. Point handles that they come near to keep their reach, without
    the vertices that the new ones hold.

    Args:
        depsgraph: for matrices.
        added: in their lists, with their groups and, for handles, their rest matrices.
        use_nodes: see versions.read_group_weights().
    """
    for entry in added:
        entry.forget_shape()
    rest = meshes.read_rest(obj)
    shown = handle_motion.shown_positions(obj, rest)
    if np.array_equal(shown, rest):
        return
    entries = [e for e in enabled_entries(obj) if e in added or not _problem(obj, e, depsgraph)]
    holder = _Holder(obj, depsgraph, entries, use_nodes)
    matrices = [_motion(obj, e, depsgraph) for e in holder.entries]
    is_new = [entry in added for entry in holder.entries]
    _keep_points(holder, matrices, shown, is_new)
    specs, points = holder.specs, holder.points(holder.specs)
    is_held = holder.is_held(specs, points)
    alone = [without_points(spec, points.get(i, ())) for i, spec in enumerate(specs)]
    others = [Moved(spec, matrix) for spec, matrix, new in zip(alone, matrices, is_new, strict=True) if not new]
    for i in np.flatnonzero(is_new):
        patches = holder.patches(points.get(i, ()), is_held)
        targets = shown.astype(np.float64)
        targets[alone[i].vertices] = staying_targets(alone[i], others, rest, shown)
        if len(patches) != 1 or len(alone[i].vertices) or not _is_average(patches[0], rest, shown, matrices[i], holder):
            vertices = np.unique(np.concatenate([specs[i].vertices, *(patch.vertices for patch in patches)]))
            holder.set_shape(i, vertices, targets[vertices], matrices[i])


def _is_average(patch: Patch, rest: Float32s, shown: Float32s, matrix: Floats, holder: _Holder) -> bool:
    """Whether the average of the patch at rest, moved by the handle, is the one that is shown."""
    average = transformed(matrix, patch.weights @ rest[patch.vertices])
    off = holder.stretch @ (average - patch.weights @ shown[patch.vertices])
    return bool(np.linalg.norm(off) <= AT_PLACE * diagonal_of(holder.surface.seen))


def _keep_points(holder: _Holder, matrices: Sequence[Floats], shown: Float32s, is_new: Sequence[bool]) -> None:
    """Lets point handles near new entries pull the surface as before, and as far. Changes ``holder.specs``."""
    specs = holder.specs
    specs_before = [
        replace(spec, vertices=spec.vertices[:0], weights=spec.weights[:0]) if new else spec
        for spec, new in zip(specs, is_new, strict=True)
    ]
    before, after = holder.points(specs_before), holder.points(specs)
    near = [i for i in before if _reaches(before[i]) != _reaches(after.get(i, ()))]
    for i in near:
        if len(before[i]) == 1:  # else each piece has another reach
            holder.entries[i].reach = before[i][0].reach / holder.surface.radius
            specs[i] = replace(specs[i], reach=holder.entries[i].reach)
    if near:
        after = holder.points(specs)
    was_held, is_held = holder.is_held(specs_before, before), holder.is_held(specs, after)
    for i in near:
        former, present = holder.patches(before[i], was_held), holder.patches(after.get(i, ()), is_held)
        if [len(patch.vertices) for patch in former] == [len(patch.vertices) for patch in present]:
            continue
        # If the mesh has not followed yet, it is still pulled as far.
        base = specs[i].base_or(holder.mesh.rest_positions).astype(np.float64)
        averages = [patch.weights @ base[patch.vertices] for patch in former]
        pulls = transformed(matrices[i], np.array(averages)) - [p.weights @ shown[p.vertices] for p in former]
        vertices = np.unique(np.concatenate([specs[i].vertices, *(patch.vertices for patch in present)]))
        holder.set_shape(i, vertices, shown[vertices] + pulls.mean(axis=0), matrices[i])


def _reaches(points: Sequence[Point]) -> list[float]:
    return [point.reach for point in points]


def _problem(obj: bpy.types.Object, entry: Entry, depsgraph: bpy.types.Depsgraph) -> str:
    return handle_motion.problem_of(obj, entry, depsgraph) if hasattr(entry, "target") else ""


def _motion(obj: bpy.types.Object, entry: Entry, depsgraph: bpy.types.Depsgraph) -> Floats:
    return handle_motion.motion_of(obj, entry, depsgraph) if hasattr(entry, "target") else np.eye(4)
