# SPDX-License-Identifier: GPL-3.0-or-later
"""What pins and handles hold, before there is a session that knows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import bpy
import numpy as np
from numpy.typing import NDArray

from ..core import native
from ..core.arrays import Float32s, Floats
from ..core.mirror import Copy, completed
from ..core.patches import PATCH_REACH, Ball, Point, Surface, held_by_themselves, points_of, without
from ..core.targets import HandleSpec, Patch
from ..core.transforms import best_rigid_fit
from ..core.unbound import local_patch, neighbourhood
from . import handle_motion, meshes, pose_key
from .inputs import groups_of, has_group, spec_of
from .snapshot import constraints_of, settings_of

if TYPE_CHECKING:
    from ..props.controls import ArapControl


class ConstraintPreview:
    """A mesh at rest, completed by its mirror images, and what can be held of it. With Blender data: use it at once."""

    def __init__(self, obj: bpy.types.Object, depsgraph: bpy.types.Depsgraph, *, use_nodes: bool | None = None) -> None:
        """``depsgraph``: for its scale. ``use_nodes``: see versions.read_group_weights()."""
        self._obj = obj
        self._use_nodes = use_nodes
        self.mesh = meshes.read_mesh(obj)
        self.n_own = len(self.mesh.rest_positions)
        self.stretch = meshes.read_stretch(obj, depsgraph)
        self._settings = settings_of(obj)
        mirrors = meshes.read_mirrors(obj, depsgraph, self.stretch, self.mesh.rest_positions)
        self.mesh, self._whole = completed(self.mesh, mirrors, self.stretch)
        seen = self.mesh.rest_positions @ self.stretch.T
        self.surface = Surface.of(seen, self.mesh.corner_vertices, self.mesh.face_sizes, self._settings.rigidity_radius)

    @cached_property
    def _rest_and_shown(self) -> tuple[Float32s, Float32s]:
        """(n, 3) each, of its own vertices."""
        rest = meshes.read_rest(self._obj)
        return rest, pose_key.shown_positions(self._obj, rest)

    @property
    def is_at_rest(self) -> bool:
        """Whether the mesh is shown at rest."""
        return np.array_equal(*self._rest_and_shown)

    @cached_property
    def shown(self) -> Floats:
        """(m, 3) the whole as it is shown."""
        return self.completed(self._rest_and_shown[1])

    def specs_of(self, entries: Sequence[ArapControl]) -> list[HandleSpec]:
        """Of entries whose groups are there."""
        names = sorted(groups_of(constraints_of(entries)))
        weights = meshes.read_weights(self._obj, names, use_nodes=self._use_nodes)
        rest = self.mesh.rest_positions[: self.n_own]
        return [spec_of(entry, weights, rest) for entry in entries]

    def others(self, entry: ArapControl | None) -> list[HandleSpec]:
        """Of the enabled pins and handles but ``entry``."""
        return [spec for other, spec in self._enabled if other != entry]

    def others_near(self, spec: HandleSpec) -> list[HandleSpec]:
        """Of the enabled pins and handles with a vertex that a new point handle may reach."""
        ball = Ball.about(self.surface.seen[spec.vertices])
        distances = np.linalg.norm(self.surface.seen[: self.n_own] - ball.centre, axis=1)
        near = np.flatnonzero(distances <= ball.radius + PATCH_REACH * self.surface.radius)
        names = meshes.groups_at(self._obj, near)
        enabled = handle_motion.enabled_controls(self._obj)
        pairs = zip(enabled, constraints_of(enabled), strict=True)
        return self.specs_of([entry for entry, hold in pairs if getattr(hold, "group", "") in names])

    @cached_property
    def _enabled(self) -> list[tuple[ArapControl, HandleSpec]]:
        entries = [e for e in handle_motion.enabled_controls(self._obj) if has_group(self._obj, e)]
        return list(zip(entries, self.specs_of(entries), strict=True))

    def completed(self, positions: NDArray[np.floating]) -> Floats:
        """Positions of the whole mesh for those of its own vertices."""
        return positions.astype(np.float64) if self._whole is None else self._whole.lifted(positions)

    def completed_specs(self, specs: Sequence[HandleSpec]) -> tuple[list[HandleSpec], list[Copy]]:
        """See mirror.MirroredMesh.specs()."""
        if self._whole is not None:
            return self._whole.specs(specs)
        return list(specs), [Copy(i, 0, (0,), np.zeros(3)) for i in range(len(specs))]

    def motions(self, matrices: Floats, copies: Sequence[Copy]) -> Floats:
        """See mirror.MirroredMesh.matrices()."""
        return matrices if self._whole is None else self._whole.matrices(matrices, copies)

    def points(self, specs: Sequence[HandleSpec]) -> dict[int, list[Point]]:
        """The points among them, by index."""
        found: dict[int, list[Point]] = {}
        has_points = self._settings.has_radius and not native.problem()
        for point in points_of(specs, self.surface) if has_points else ():
            found.setdefault(point.handle, []).append(point)
        return found

    def is_held(self, specs: Sequence[HandleSpec], points: Mapping[int, Sequence[Point]]) -> NDArray[np.bool_]:
        """See held_by_themselves()."""
        of_points = {i: [point.vertices for point in of_handle] for i, of_handle in points.items()}
        return held_by_themselves(specs, of_points, len(self.surface.seen))

    def patches(self, points: Sequence[Point], is_held: NDArray[np.bool_]) -> list[Patch]:
        """Of these points, without vertices that are held by themselves."""
        found = (self._patch(point) for point in points)
        left = (without(patch, is_held) for patch in found if patch is not None)
        return [patch for patch in left if patch is not None]

    def _patch(self, point: Point) -> Patch | None:
        mesh, seen = self.mesh, self.surface.seen
        part = neighbourhood(seen, mesh.corner_vertices, mesh.face_sizes, point.vertices, point.reach)
        return local_patch(
            native.load(), mesh.rest_positions, part, point.vertices, point.reach, self.stretch, self._settings
        )


@dataclass(frozen=True)
class HandlePlacement:
    """Where a new handle stands.

    Attributes:
        motion: (4, 4) object-space motion, rigid as seen, from rest to the pose shown of what it holds.
        centre: (3,) the average at rest that a point handle holds, object space; None: it holds vertices.
    """

    motion: Floats
    centre: Floats | None


def place_handle(held: ConstraintPreview, spec: HandleSpec, entry: ArapControl | None = None) -> HandlePlacement:
    """Where a handle stands that holds ``spec``, with at least one vertex. ``entry``: itself, if it is in the list."""
    patch = _patch_of(held, spec, entry)
    centre = None if patch is None else patch.centre
    if held.is_at_rest:
        return HandlePlacement(np.eye(4), centre)
    vertices, weights = (spec.vertices, None) if patch is None else (patch.vertices, patch.weights)
    at_rest, posed = held.mesh.rest_positions[vertices], held.shown[vertices]
    return HandlePlacement(best_rigid_fit(at_rest, posed, held.stretch, weights), centre)


def _patch_of(held: ConstraintPreview, spec: HandleSpec, entry: ArapControl | None) -> Patch | None:
    """The patch of a handle that is one point."""
    alone, _ = held.completed_specs([spec])
    if [len(point.vertices) for point in held.points(alone).get(0, ())] != [len(alone[0].vertices)]:
        return None  # quick, and most handles are none
    others = held.others_near(spec) if entry is None else held.others(entry)
    specs, _ = held.completed_specs([spec, *others])
    points = held.points(specs)
    patches = held.patches(points.get(0, ()), held.is_held(specs, points))
    return patches[0] if len(patches) == 1 else None
