# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices a pull moves and which it holds, and their mirror images. No bpy."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..core.arrays import Floats, Ints
from ..core.graph import connected_labels
from ..core.loose.near import Cells
from ..core.patches import diagonal_of
from ..core.session_data import SessionMesh
from ..core.targets import HandleSpec
from ..core.transforms import nearest_rotations
from .coarse import RestMesh
from .limb import bone_length, border_of, limb_of, root_of

MIRROR_TOLERANCE = 1e-4  # largest distance between mirror images, as a fraction of the diagonal
FREE_SHARE = 0.4  # the part of the reach that is not held at all
LEAST_HOLD = 1e-3  # the step between weights, as in vertex groups: see groups.write()

Signs = tuple[float, float, float]
"""A mirror image, object space: -1 for every mirrored axis."""
ITSELF: Signs = (1.0, 1.0, 1.0)

_last_fine: RestMesh | None = None


@dataclass(frozen=True)
class PulledPatch:
    """A piece of the surface that is held or dragged.

    Attributes:
        vertices: (k,) int32, ascending.
        reach: distance around the piece within which the mesh is free if no pin is set, in world units; 0: a set pin.
        root: distance along the surface to the root of the limb, which is free instead; 0: on no limb; None: not known
            yet.
        image: the mirror image of the piece under the mouse that this is.
        planes: the mirrors that map the piece under the mouse to itself: it lies on these planes.
    """

    vertices: Ints
    reach: float = 0.0
    root: float | None = 0.0
    image: Signs = ITSELF
    planes: tuple[Signs, ...] = ()

    def motion(self, grabbed: Floats, centre: Floats, stretch: Floats) -> Floats:
        """(4, 4) object-space motion of this piece.

        Args:
            grabbed: (4, 4) motion of the piece under the mouse, rigid as seen.
            centre: (3,) centre of the piece under the mouse.
            stretch: (3, 3) stretch of the object.
        """
        mirror = np.diag([*self.image, 1.0])
        return np.asarray(mirror @ _symmetric(grabbed, self.planes, centre, stretch) @ mirror)


def _symmetric(motion: Floats, planes: Sequence[Signs], centre: Floats, stretch: Floats) -> Floats:
    """The rigid motion nearest to ``motion`` that is its own mirror image."""
    if not planes:
        return motion
    images = [motion, *(np.diag([*signs, 1.0]) @ motion @ np.diag([*signs, 1.0]) for signs in planes)]
    mean: Floats = np.mean(images, axis=0)
    on_planes = np.mean([centre, *(centre * signs for signs in planes)], axis=0)
    unstretch = np.linalg.inv(stretch)
    result = np.eye(4)
    result[:3, :3] = unstretch @ nearest_rotations(stretch @ mean[:3, :3] @ unstretch) @ stretch
    result[:3, 3] = mean[:3, :3] @ on_planes + mean[:3, 3] - result[:3, :3] @ on_planes
    return result


def symmetric_grabs(rest: Floats, edges: Ints, grab: PulledPatch, axes: Sequence[bool]) -> list[PulledPatch]:
    """The piece under the mouse, joined with the mirror images that touch it, then its other images.

    Args:
        rest: (n, 3) rest positions, object space.
        edges: (e, 2).
        grab: the piece under the mouse.
        axes: whether x, y and z are mirrored.

    Raises:
        ValueError: most of these vertices have no mirror image. The caller puts the object's name before the message.
    """
    piece, planes = grab.vertices, []
    for signs in mirror_signs(axes):
        image = mirror_images(rest, edges, grab.vertices, signs)
        if 2 * len(image) < len(grab.vertices):
            names = " and ".join(name for name, sign in zip("XYZ", signs, strict=True) if sign < 0.0)
            raise ValueError(f"is not symmetric here: turn off Mirror {names}")
        if np.isin(image, grab.vertices).any():
            piece = np.union1d(piece, image).astype(np.int32)
            planes.append(signs)
    grabs = [replace(grab, vertices=piece, planes=tuple(planes))]
    taken = piece
    for signs in mirror_signs(axes):
        image = mirror_images(rest, edges, piece, signs)
        if not np.isin(image, taken).any():
            grabs.append(replace(grabs[0], vertices=image, image=signs))
            taken = np.union1d(taken, image)
    return grabs


def connected_within(points: Floats, edges: Ints, seeds: Ints, centre: Floats, radius: float) -> Ints:
    """(k,) int32 vertices within ``radius`` of ``centre`` that edges inside connect to one of ``seeds``.

    If no seed is within the radius, it is the seed nearest to the centre: so a coarse mesh can be pulled too.

    Args:
        points: (n, 3).
        edges: (e, 2).
        seeds: vertices of the face at the centre.
        centre: (3,).
        radius: Euclidean distance.
    """
    offset = points - centre
    is_near = np.einsum("ij,ij->i", offset, offset) <= radius * radius
    if not is_near[seeds].any():
        nearest = seeds[np.linalg.norm(points[seeds] - centre, axis=1).argmin()]
        return np.array([nearest], dtype=np.int32)
    near = np.flatnonzero(is_near)
    inside = edges[is_near[edges[:, 0]] & is_near[edges[:, 1]]]
    labels = connected_labels(len(near), *np.searchsorted(near, inside).T)
    of_seeds = labels[np.searchsorted(near, seeds[is_near[seeds]])]
    return near[np.isin(labels, of_seeds)].astype(np.int32)


def fine_of(mesh: SessionMesh, stretch: Floats, edges: Ints) -> RestMesh:
    """The mesh at rest, as seen. The last one is kept: the next drag is mostly of the same mesh."""
    global _last_fine  # noqa: PLW0603 - what is read of a mesh lives as long as the file
    fine = RestMesh(mesh.rest_positions @ stretch.T, edges, mesh.corner_vertices, mesh.face_sizes)
    if _last_fine is None or not fine.is_same_as(_last_fine):
        _last_fine = fine
    return _last_fine


def forget_fine() -> None:
    """Gives the memory of the last mesh back."""
    global _last_fine  # noqa: PLW0603
    _last_fine = None


def with_root(fine: RestMesh, grabs: Sequence[PulledPatch]) -> tuple[PulledPatch, ...]:
    """A piece and its mirror images, with the root of the limb that they are on."""
    first = grabs[0]
    root = first.root
    if root is None:
        root = root_of(fine.coarse, first.vertices, _ball_of(fine.points, first.vertices)[1])
    return tuple(replace(grab, root=root) for grab in grabs)


@dataclass(frozen=True)
class Joint:
    """Where the limb that is pulled meets the rest.

    Attributes:
        vertices: (k,) around it.
        length: of the limb, from the pulled piece to the joint, in world units.
    """

    vertices: Ints
    length: float


def joint_of(fine: RestMesh, grab: PulledPatch) -> Joint | None:
    """None if the piece is on no limb."""
    if not grab.root:
        return None
    border = border_of(fine, limb_of(fine, grab.vertices, grab.root))
    return Joint(border, bone_length(fine, grab.vertices, grab.root)) if len(border) else None


def hold_of_rest(fine: RestMesh, grabs: Sequence[PulledPatch], *, use_loose_parts: bool) -> HandleSpec:
    """Holds the vertices beyond the limbs of ``grabs``, or where there is no limb beyond their reach.

    From FREE_SHARE of the reach on the hold grows from soft.

    Args:
        grabs: each with a reach and a root.
        use_loose_parts: does not hold the loose pieces that follow the pulled ones.
    """
    weights = np.ones(len(fine.points))
    if use_loose_parts:
        weights[fine.going_along(np.concatenate([grab.vertices for grab in grabs]))] = 0.0
    for grab in grabs:
        if grab.root:
            weights[limb_of(fine, grab.vertices, grab.root)] = 0.0
        else:
            free, weights_of_free = _fading(fine, grab)
            weights[free] = np.minimum(weights[free], weights_of_free)
        weights[grab.vertices] = 0.0
    # As fine as a vertex group holds them, so that a pin made of this holds the same.
    is_soft = weights < 1.0
    weights[is_soft] = np.minimum(np.rint(weights[is_soft] / LEAST_HOLD) * LEAST_HOLD, 1.0 - LEAST_HOLD)
    held = np.flatnonzero(weights > 0.0).astype(np.int32)
    # Make Handles calls its pin so. "Rest" would be taken for the mesh at rest.
    return HandleSpec("Everything Else", held, weights[held])


def _ball_of(points: Floats, vertices: Ints) -> tuple[Floats, float]:
    """Centre and radius of a piece."""
    centre: Floats = points[vertices].mean(axis=0)
    return centre, float(np.linalg.norm(points[vertices] - centre, axis=1).max())


def _fading(fine: RestMesh, grab: PulledPatch) -> tuple[Ints, Floats]:
    """(k,) the vertices within the reach, and how strongly each is held."""
    centre, radius = _ball_of(fine.points, grab.vertices)
    free = connected_within(fine.points, fine.edges, grab.vertices, centre, radius + grab.reach)
    beyond = np.linalg.norm(fine.points[free] - centre, axis=1) - radius
    share = np.clip((beyond / grab.reach - FREE_SHARE) / (1.0 - FREE_SHARE), 0.0, 1.0)
    return free, share * share * (3.0 - 2.0 * share)


def mirror_signs(axes: Sequence[bool]) -> Iterator[Signs]:
    """All mirror images in the planes of these axes but the identity: 1, 3 or 7 of them."""
    choices = [(1.0, -1.0) if is_mirrored else (1.0,) for is_mirrored in axes]
    images = itertools.product(*choices)
    next(images)
    yield from images


def mirror_images(rest: Floats, edges: Ints, vertices: Ints, signs: Sequence[float]) -> Ints:
    """(m,) int32 ascending, the vertices at the mirror images of ``vertices``. Some may have none.

    Of several vertices at one place (an open seam, touching surfaces) it takes the one connected to most of the image.

    Args:
        rest: (n, 3) rest positions.
        edges: (e, 2).
        vertices: (k,).
        signs: (3,) of 1 and -1.
    """
    cells = Cells(rest, MIRROR_TOLERANCE * diagonal_of(rest))
    rows, candidates, distances = cells.pairs(rest[vertices] * np.asarray(signs))
    is_found = np.zeros(len(rest), dtype=bool)
    is_found[candidates] = True
    found = np.flatnonzero(is_found)
    inside = edges[is_found[edges[:, 0]] & is_found[edges[:, 1]]]
    labels = connected_labels(len(found), *np.searchsorted(found, inside).T)
    pieces = labels[np.searchsorted(found, candidates)]
    sizes = np.bincount(labels, minlength=len(found))[pieces]
    best_first = np.lexsort((distances, pieces, -sizes, rows))
    _, best = np.unique(rows[best_first], return_index=True)
    images: Ints = np.unique(candidates[best_first[best]]).astype(np.int32)
    return images
