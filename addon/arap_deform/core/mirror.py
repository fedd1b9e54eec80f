# SPDX-License-Identifier: GPL-3.0-or-later
"""Half a mesh and its mirror images as one mesh, which is what is posed. No bpy.

So vertices on a mirror plane stay on it, the surface is smooth across it, and thin parts that it cuts are seen whole.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats, Ints
from .patches import surface_diagonal
from .session_data import SessionMesh
from .targets import HandleSpec, Segment
from .transforms import nearest_rotations, transformed

# Single precision moves the same plane by less, and a vertex on it, as a fraction of the coordinates' size.
SAME_PLANE = 1e-5
ON_PLANE = 4e-6


@dataclass(frozen=True, eq=False)
class Mirror:
    """A mirror plane.

    Attributes:
        matrix: (4, 4) the reflection, object space.
        merge_distance: a vertex that is nearer than this to its image lies on the plane.
        size: of the coordinates that the plane was found from, which may be far from the origin; object space.
    """

    matrix: Floats
    merge_distance: float
    size: float = 0.0

    def is_same_as(self, other: Mirror) -> bool:
        size = max(1.0, self.size, other.size, float(np.abs(self.matrix).max()))
        is_near = np.abs(self.matrix - other.matrix).max() <= SAME_PLANE * size
        return bool(is_near) and self.merge_distance == other.merge_distance

    def sides(self, positions: NDArray[np.floating]) -> Floats:
        """(n,) on which side of the plane (n, 3) ``positions`` are, -1 or 1; 0 if they are on it."""
        # All vertices go to their images in one direction, there or back.
        ways = self.matrix[:3, :3] - np.eye(3)
        direction = ways[:, np.linalg.norm(ways, axis=0).argmax()]
        direction = direction / np.linalg.norm(direction)
        distances = positions @ (direction @ ways) + direction @ self.matrix[:3, 3]
        size = max(self.size, float(np.abs(positions).max(initial=0.0)))
        return np.asarray(np.sign(distances) * (np.abs(distances) > self.merge_distance + ON_PLANE * size))


def are_same(mirrors: Sequence[Mirror], others: Sequence[Mirror]) -> bool:
    return len(mirrors) == len(others) and all(a.is_same_as(b) for a, b in zip(mirrors, others, strict=True))


def used_mirrors(mirrors: Sequence[Mirror], rest: NDArray[np.floating], stretch: Floats) -> tuple[Mirror, ...]:
    """The mirrors that complete the mesh: it lies on one side and touches the plane, and the image looks the same."""
    used = []
    for mirror in mirrors:
        sides = mirror.sides(rest)
        is_half = (sides < 0.0).any() != (sides > 0.0).any() and (sides == 0.0).any()
        seen = stretch @ mirror.matrix[:3, :3] @ np.linalg.inv(stretch)
        if is_half and np.abs(seen @ seen.T - np.eye(3)).max() <= 1e-4:
            used.append(mirror)
    return tuple(used)


@dataclass(frozen=True)
class Copy:
    """What a handle holds in the whole mesh: its own vertices and images that touch them, or an image of that.

    Attributes:
        handle: its index.
        image: number of the image.
        own: numbers of the images that belong to it.
        centre: (3,) of it, on the planes of ``own``; before the image is taken.
    """

    handle: int
    image: int
    own: tuple[int, ...]
    centre: Floats


class MirroredMesh:
    """The mesh with its images, welded at the planes. The mesh's own vertices come first.

    Attributes:
        mesh: the whole. Own vertices on a plane are put exactly on it.
        sources: (m,) the own vertex of which each is an image.
    """

    def __init__(self, mesh: SessionMesh, mirrors: Sequence[Mirror], stretch: Floats) -> None:
        """``mirrors``: used_mirrors(). Their reflections must commute, as those of one object's axes do."""
        positions = mesh.rest_positions.copy()
        corners, sizes = mesh.corner_vertices, mesh.face_sizes
        self.n_own = len(positions)
        self._stretch, self._unstretch = stretch, np.asarray(np.linalg.inv(stretch), dtype=np.float64)
        self._mirrors = tuple(mirrors)
        self._own_sides = [float(np.sign(mirror.sides(positions).sum())) for mirror in mirrors]
        self._matrices = np.eye(4)[None]
        self._images = np.arange(self.n_own)[None]  # of each own vertex; bits of the row number are mirrors
        for mirror in mirrors:
            n = len(positions)
            flipped = transformed(mirror.matrix, positions)
            is_on = mirror.sides(positions) == 0.0
            positions[is_on] = 0.5 * (positions + flipped)[is_on]
            image = np.arange(n)
            image[~is_on] = n + np.arange(n - is_on.sum())
            flipped_corners, flipped_sizes = _reversed(image[corners], sizes, ~is_on[corners])
            corners = np.concatenate([corners, flipped_corners]).astype(np.int32)
            sizes = np.concatenate([sizes, flipped_sizes]).astype(np.int32)
            positions = np.concatenate([positions, flipped[~is_on]])
            self._images = np.concatenate([self._images, image[self._images]])
            self._matrices = np.concatenate([self._matrices, mirror.matrix @ self._matrices])
        self.mesh = SessionMesh(positions, corners, sizes)
        self.sources: Ints = np.empty(len(positions), dtype=np.int32)
        self.sources[self._images] = np.arange(self.n_own, dtype=np.int32)

    def permutations(self) -> list[Ints]:
        """(m,) for each mirror image: the vertices at the places of all vertices in it."""
        result: list[Ints] = []
        for image in range(1, len(self._images)):
            mapped = np.empty(len(self.sources), dtype=np.int32)
            for own, of_own in enumerate(self._images):
                mapped[of_own] = self._images[own ^ image]
            result.append(mapped)
        return result

    def lifted(self, positions: NDArray[np.floating]) -> Floats:
        """(m, 3) the whole for (n, 3) ``positions`` of its own vertices."""
        total = np.zeros((len(self.sources), 3))
        n_images = np.zeros(len(self.sources))
        for matrix, image in zip(self._matrices, self._images, strict=True):
            total[image] += transformed(matrix, positions)
            n_images[image] += 1.0
        return np.asarray(total / n_images[:, None])

    def regions(self, of_own: Ints | None) -> Ints | None:
        """(m,) the rigid regions: one that touches a plane is one body with its image."""
        if of_own is None:
            return None
        result = np.full(len(self.sources), -1, dtype=np.int32)
        for region in np.unique(of_own[of_own >= 0]):
            vertices = np.flatnonzero(of_own == region)
            for number, copy in enumerate(self._cosets(vertices)):
                result[np.unique(self._images[list(copy)][:, vertices])] = region + number * (of_own.max() + 1)
        return result

    def specs(self, specs: Sequence[HandleSpec]) -> tuple[list[HandleSpec], list[Copy]]:
        """The handles and their images. A handle that touches a plane is one with its image.

        A bone of another half holds nothing: there it would fight with the image of its twin.
        """
        result, copies = [], []
        for i, spec in enumerate(specs):
            base = None if spec.base is None else self.lifted(spec.base)
            bone = spec.segment if spec.segment is not None and self._is_own(spec.segment) else None
            if spec.segment is None:
                cosets = self._cosets(spec.vertices[spec.weights >= 1.0])
                own = self._images[list(cosets[0])][:, spec.vertices]
                centre = self.mesh.rest_positions[own].reshape(-1, 3).mean(axis=0) if own.size else np.zeros(3)
            else:
                cosets = self._cosets_of_segment(spec.segment)
                centre = spec.segment.ends.mean(axis=0)
            for coset in cosets:
                vertices, first = np.unique(self._images[list(coset)][:, spec.vertices], return_index=True)
                weights = np.tile(spec.weights, len(coset))[first]
                segment = None if bone is None else self._image_of(bone, coset[0])
                result.append(
                    replace(spec, vertices=vertices.astype(np.int32), weights=weights, base=base, segment=segment)
                )
                copies.append(Copy(i, coset[0], cosets[0], centre))
        return result, copies

    def matrices(self, matrices: Floats, copies: Sequence[Copy]) -> Floats:
        """(h, 4, 4) motions of the ``copies`` of specs(), for the motions of the handles."""
        result = np.empty((len(copies), 4, 4))
        for row, copy in zip(result, copies, strict=True):
            flip = self._matrices[copy.image]
            row[...] = flip @ self._symmetric(matrices[copy.handle], copy) @ flip
        return result

    def _cosets(self, vertices: NDArray[np.integer]) -> list[tuple[int, ...]]:
        """Images that touch each other at these vertices, by numbers; the own vertices come first."""
        return self._cosets_with(lambda image: bool((self._images[image, vertices] == vertices).any()))

    def _cosets_of_segment(self, segment: Segment) -> list[tuple[int, ...]]:
        """The same of a bone: it is one with its image if it lies on the plane."""
        near = ON_PLANE * max(1.0, float(np.abs(self.mesh.rest_positions).max()))
        return self._cosets_with(
            lambda image: bool(np.abs(self._image_of(segment, image).ends - segment.ends).max() <= near)
        )

    def _cosets_with(self, belongs: Callable[[int], bool]) -> list[tuple[int, ...]]:
        own = {0}
        for image in range(1, len(self._images)):
            if belongs(image):
                own |= {image ^ other for other in own}
        return sorted({tuple(sorted(image ^ other for other in own)) for image in range(len(self._images))})

    def _is_own(self, segment: Segment) -> bool:
        """Whether its middle is in the mesh's own half."""
        middle = segment.ends.mean(axis=0)[None]
        sides = (mirror.sides(middle)[0] for mirror in self._mirrors)
        return all(side in (0.0, own) for side, own in zip(sides, self._own_sides, strict=True))

    def _image_of(self, segment: Segment, image: int) -> Segment:
        flip = self._matrices[image]
        return Segment(transformed(flip, segment.ends), flip @ segment.motion @ flip)

    def _symmetric(self, motion: Floats, copy: Copy) -> Floats:
        """The motion near ``motion`` that keeps the piece on its planes: means of rotation, stretch and way."""
        flips = self._matrices[list(copy.own)]
        images = flips @ motion @ flips
        if np.abs(images - motion).max() <= 1e-12 * np.abs(motion).max():
            return motion
        seen = self._stretch @ images[:, :3, :3] @ self._unstretch
        rotations = nearest_rotations(seen)
        rotation = nearest_rotations(rotations.mean(axis=0)[None])[0]
        scale = (rotations.transpose(0, 2, 1) @ seen).mean(axis=0)
        result = np.eye(4)
        result[:3, :3] = self._unstretch @ rotation @ scale @ self._stretch
        result[:3, 3] = (images[:, :3, :3] @ copy.centre + images[:, :3, 3]).mean(axis=0) - result[:3, :3] @ copy.centre
        return result


def _reversed(corners: Ints, sizes: Ints, is_off: NDArray[np.bool_]) -> tuple[Ints, Ints]:
    """Faces with their corners in reverse order, without those with no corner ``is_off`` the plane."""
    ends = np.cumsum(sizes, dtype=np.int64)
    starts = ends - sizes
    order = np.repeat(starts + ends - 1, sizes) - np.arange(len(corners))
    is_kept = np.logical_or.reduceat(is_off, starts) if len(sizes) else np.zeros(0, dtype=bool)
    return corners[order][np.repeat(is_kept, sizes)], sizes[is_kept]


def completed(mesh: SessionMesh, mirrors: Sequence[Mirror], stretch: Floats) -> tuple[SessionMesh, MirroredMesh | None]:
    """The mesh with its images; the mesh itself and None without mirrors. ``mirrors``: used_mirrors()."""
    whole = MirroredMesh(mesh, mirrors, stretch) if mirrors else None
    return (mesh if whole is None else whole.mesh), whole


def seen_size(mesh: SessionMesh, mirrors: Sequence[Mirror], stretch: Floats) -> float:
    """The diagonal of the mesh, completed by the mirrors, as seen."""
    whole, _ = completed(mesh, mirrors, stretch)
    return surface_diagonal(whole.rest_positions @ stretch.T, whole.corner_vertices)
