# SPDX-License-Identifier: GPL-3.0-or-later
"""From the matrices of handles to the targets of vertices.

Solver space is object space times the stretch: X = S x. A handle's motion T acts in object space, so a vertex's
target is S T x = A x + b. What does not depend on T is computed once for a set of handles.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats, Ints
from .transforms import map_points, nearest_rotations, transformed


@dataclass(frozen=True)
class Segment:
    """A bone in the mesh: what is around it moves with the bone.

    Attributes:
        ends: (2, 3) float64 head and tail at rest, object space.
        motion: (4, 4) object-space motion since rest, while the handle has not moved.
    """

    ends: Floats
    motion: Floats = field(default_factory=lambda: np.eye(4))

    def is_same_as(self, other: Segment | None) -> bool:
        return other is not None and np.array_equal(self.ends, other.ends)


@dataclass(frozen=True)
class HandleSpec:
    """A group of vertices, or a bone without one, that follows one matrix. A pin is a handle that never moves.

    Attributes:
        name: for messages.
        vertices: (k,) int32.
        weights: (k,) float64; 1 is hard, between 0 and 1 soft, 0 free.
        use_exact: holds its vertices, however few. Else it may be a point handle, see patches.
        base: (n, 3) the whole mesh while the handle has not moved; None: at rest.
        reach: of the patch of a point handle, in rigidity radii; 0: as far as other handles let it reach.
        segment: holds this, for models with an inside; then without vertices.
    """

    name: str
    vertices: Ints
    weights: Floats
    use_exact: bool = True
    base: NDArray[np.floating] | None = None
    reach: float = 0.0
    segment: Segment | None = None

    def is_same_as(self, other: HandleSpec) -> bool:
        """Whether both hold the same in the same way, from whatever place."""
        return (
            self.use_exact == other.use_exact
            and self.reach == other.reach
            and (other.segment is None if self.segment is None else self.segment.is_same_as(other.segment))
            and np.array_equal(self.vertices, other.vertices)
            and np.array_equal(self.weights, other.weights)
        )

    def base_or(self, rest: NDArray[np.floating]) -> NDArray[np.floating]:
        """(n, 3) the whole mesh while the handle has not moved."""
        return rest if self.base is None else self.base

    def has_base_of(self, other: HandleSpec) -> bool:
        """Whether both hold the mesh from the same place. Of handles that are the same."""
        if self.segment is not None and other.segment is not None:
            return np.array_equal(self.segment.motion, other.segment.motion)
        if self.base is None or other.base is None:
            return self.base is other.base
        return self.base is other.base or np.array_equal(self.base, other.base)


@dataclass(frozen=True)
class Patch:
    """What a point handle holds: the weighted average of a piece of the surface.

    Attributes:
        vertices: (m,) int32.
        weights: (m,) float64, of sum 1.
        centre: (3,) float64 that average while the handle has not moved, object space.
        sources: (k,) int32 the handle's own vertices, which the patch holds in their place.
    """

    vertices: Ints
    weights: Floats
    centre: Floats
    sources: Ints


Patches = Mapping[int, Sequence[Patch]]
"""What point handles hold, by index of the handle: a patch for each of its pieces."""

CORNERS = 4
"""Rows of targets that a segment has."""

NO_PATCHES: Patches = MappingProxyType({})


def check_specs(specs: Sequence[HandleSpec], n_vertices: int) -> None:
    """Raises ValueError if a handle's vertices are out of range, or not as many as its weights."""
    for spec in specs:
        vertices, weights = np.asarray(spec.vertices), np.asarray(spec.weights)
        if vertices.shape != weights.shape or vertices.ndim != 1:
            raise ValueError(
                f"Handle '{spec.name}' has vertices of shape {vertices.shape} but weights of shape "
                f"{weights.shape}: give one weight per vertex"
            )
        if vertices.size and (vertices.min() < 0 or vertices.max() >= n_vertices):
            raise ValueError(f"Handle '{spec.name}' has a vertex outside 0 to {n_vertices - 1}: check its vertex group")


def checked_matrices(matrices: Floats, specs: Sequence[HandleSpec]) -> Floats:
    """(h, 4, 4) float64. Raises ValueError if there is not one for each handle, or one is not finite."""
    matrices = np.asarray(matrices, dtype=np.float64)
    if matrices.shape != (len(specs), 4, 4):
        raise ValueError(f"matrices have shape {matrices.shape}, expected ({len(specs)}, 4, 4)")
    finite = np.isfinite(matrices).all(axis=(1, 2))
    if not finite.all():
        name = specs[int(np.flatnonzero(~finite)[0])].name
        raise ValueError(f"Handle '{name}' has a transform that is not finite: reset it")
    return matrices


class HandleMap:
    """Rows of targets for a set of handles.

    First the vertices of a single handle, ordered by handle, then the shared ones, then the patches, then the segments.

    Attributes:
        vertices: (k,) int32 constrained vertices, each once.
        strengths: (k,) float64 in (0, 1]: the largest weight of each vertex.
        patches: (offsets, vertices, weights) of the p patches, one after the other; None without any.
        segments: (s, 2, 3) float64 head and tail of each, solver space; None without any.
    """

    def __init__(
        self,
        specs: Sequence[HandleSpec],
        rest_positions: Floats,
        stretch: Floats,
        patches: Patches = NO_PATCHES,
    ) -> None:
        """Prepares the map.

        Args:
            specs: the handles, in the order of the matrices that targets() takes.
            rest_positions: (n, 3) float64, object space.
            stretch: (3, 3) float64, symmetric.
            patches: of the point handles.

        Raises:
            ValueError: a vertex out of range, or no weight above 0 anywhere.
        """
        check_specs(specs, len(rest_positions))
        self._specs = tuple(specs)
        self._stretch = stretch
        of_patches, of_segments = self._set_patches(patches), self._set_segments()
        self._point_handles, self._points = map(np.concatenate, zip(of_patches, of_segments, strict=True))
        handle, vertex, weight = self._entries(patches)
        n_entries = np.bincount(vertex, minlength=len(rest_positions))
        is_shared = n_entries[vertex] > 1

        singles = np.flatnonzero(~is_shared)  # entries are by handle already
        shared = np.flatnonzero(is_shared)[np.argsort(vertex[is_shared], kind="stable")]
        shared_vertices = np.flatnonzero(n_entries > 1)
        counts = n_entries[shared_vertices]
        self.vertices: Ints = np.concatenate([vertex[singles], shared_vertices]).astype(np.int32)

        starts = np.cumsum(counts) - counts
        largest = np.maximum.reduceat(weight[shared], starts) if len(starts) else np.empty(0)
        self.strengths: Floats = np.concatenate([weight[singles], largest])

        base = self._base_of(handle, vertex, rest_positions)
        bounds = np.searchsorted(handle[singles], np.arange(len(self._specs) + 1))
        self._blocks = [slice(int(a), int(b)) for a, b in pairwise(bounds)]
        self._single_base = np.ascontiguousarray(base[singles])
        self._single_handles = handle[singles]

        self._shared_base = base[shared]
        self._shared_handles = handle[shared]
        self._shared_starts = starts
        totals = np.add.reduceat(weight[shared], starts) if len(starts) else np.empty(0)
        self._shared_shares = weight[shared] / np.repeat(totals, counts)

        self._matrices: Floats = np.full((len(self._specs), 4, 4), np.nan)
        self._targets = np.empty((len(self.vertices) + len(self._points), 3))

    @property
    def constraints(self) -> tuple[Any, ...]:
        """What a model's set_constraints() is called with."""
        return self.vertices, self.strengths, self.patches, self.segments

    def _set_patches(self, patches: Patches) -> tuple[NDArray[np.intp], Floats]:
        """Returns the handle and the centre of each."""
        by_handle = [(handle, patch) for handle in sorted(patches) for patch in patches[handle]]
        ordered = [patch for _, patch in by_handle]
        self.patches: tuple[Ints, Ints, Floats] | None = None
        if ordered:
            self.patches = (
                np.cumsum([0, *(len(patch.vertices) for patch in ordered)], dtype=np.int32),
                np.concatenate([patch.vertices for patch in ordered]).astype(np.int32),
                np.concatenate([patch.weights for patch in ordered]).astype(np.float64),
            )
        centres = np.array([patch.centre for patch in ordered]).reshape(-1, 3)
        return np.array([handle for handle, _ in by_handle], dtype=np.intp), centres

    def _set_segments(self) -> tuple[NDArray[np.intp], Floats]:
        """Returns the handle and the place of each of their corners, four a segment."""
        held = [(i, spec.segment) for i, spec in enumerate(self._specs) if spec.segment is not None]
        self.segments: Floats | None = None
        if not held:
            return np.empty(0, dtype=np.intp), np.empty((0, 3))
        self.segments = np.array([segment.ends @ self._stretch.T for _, segment in held])
        heads, ways = self.segments[:, 0], self.segments[:, 1] - self.segments[:, 0]
        lengths = np.linalg.norm(ways, axis=1)[:, None, None]
        corners = heads[:, None, :] + lengths * np.concatenate([np.zeros((1, 3)), np.eye(3)])
        at_rest = corners @ np.linalg.inv(self._stretch).T
        motions = [segment.motion for _, segment in held]
        places = [transformed(motion, rest) for motion, rest in zip(motions, at_rest, strict=True)]
        return np.repeat(np.array([i for i, _ in held], dtype=np.intp), CORNERS), np.concatenate(places)

    def _entries(self, patches: Patches) -> tuple[NDArray[np.intp], Ints, Floats]:
        """Handle, vertex and weight of every weight above 0, ordered by handle; without what patches hold."""
        nothing = np.empty(0, np.intp), np.empty(0, np.int32), np.empty(0)
        parts: list[tuple[NDArray[np.intp], Ints, Floats]] = [nothing]
        for i, spec in enumerate(self._specs):
            vertices = np.asarray(spec.vertices, dtype=np.int32)
            weights = np.asarray(spec.weights, dtype=np.float64)
            used = weights > 0.0
            if i in patches:
                used &= ~np.isin(vertices, np.concatenate([patch.sources for patch in patches[i]]))
            parts.append((np.full(used.sum(), i), vertices[used], np.minimum(weights[used], 1.0)))
        handle, vertex, weight = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        if not len(vertex) and not patches and self.segments is None:
            raise ValueError("No vertex is pinned or has a handle: add a pin or a handle, or give its group weight")
        return handle, vertex, weight

    def _base_of(self, handle: NDArray[np.intp], vertex: Ints, rest_positions: Floats) -> Floats:
        """Where each entry's vertex stands while its handle has not moved."""
        base = rest_positions[vertex]
        for i, spec in enumerate(self._specs):
            if spec.base is not None:
                mine = handle == i
                base[mine] = spec.base[vertex[mine]]
        return base

    @property
    def n_handles(self) -> int:
        return len(self._specs)

    def targets(self, matrices: Floats) -> Floats:
        """(k + p + 4 s, 3) float64 targets in solver space; valid until the next call.

        A row for each vertex and patch, and four for each segment: its head, and as far from it as the segment is long
        along each axis.

        Args:
            matrices: (h, 4, 4) float64 object-space motion of each handle.

        Raises:
            ValueError: wrong shape, or a matrix that is not finite (names the handle).
        """
        matrices = checked_matrices(matrices, self._specs)
        moved = (matrices != self._matrices).any(axis=(1, 2))
        if not moved.any():
            return self._targets
        linear = self._stretch @ matrices[:, :3, :3]
        offset = matrices[:, :3, 3] @ self._stretch.T
        for h in np.flatnonzero(moved):
            block = self._blocks[h]
            rows = self._targets[block]
            map_points(self._single_base[block], linear[h], rows)
            rows += offset[h]
        n_single, n_vertices = len(self._single_base), len(self.vertices)
        if len(self._shared_starts) and moved[self._shared_handles].any():
            self._targets[n_single:n_vertices] = self._shared_targets(linear, offset)
        of_point = self._point_handles
        self._targets[n_vertices:] = np.matmul(linear[of_point], self._points[:, :, None])[:, :, 0] + offset[of_point]
        self._matrices = matrices.copy()
        return self._targets

    def _shared_targets(self, linear: Floats, offset: Floats) -> Floats:
        moved = np.matmul(linear[self._shared_handles], self._shared_base[:, :, None])[:, :, 0]
        moved += offset[self._shared_handles]
        moved *= self._shared_shares[:, None]
        return np.asarray(np.add.reduceat(moved, self._shared_starts, axis=0))

    def rotations(self, matrices: Floats) -> Floats:
        """(k + p + 4 s, 3, 3) float64 rotation of the handle of each target in solver space.

        Shared vertices take the mean.
        """
        matrices = checked_matrices(matrices, self._specs)
        seen = self._stretch @ matrices[:, :3, :3] @ np.linalg.inv(self._stretch)
        rotations = nearest_rotations(seen)
        result = np.empty((len(self._targets), 3, 3))
        n_single, n_vertices = len(self._single_base), len(self.vertices)
        result[:n_single] = rotations[self._single_handles]
        if len(self._shared_starts):
            weighted = rotations[self._shared_handles] * self._shared_shares[:, None, None]
            result[n_single:n_vertices] = nearest_rotations(np.add.reduceat(weighted, self._shared_starts, axis=0))
        result[n_vertices:] = rotations[self._point_handles]
        return result
