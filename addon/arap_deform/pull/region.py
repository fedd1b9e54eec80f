# SPDX-License-Identifier: GPL-3.0-or-later
"""Which vertices a pull takes along, what it holds, and the mirror images of both. No bpy."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Floats, Ints
from ..core.graph import connected_labels
from ..core.patches import diagonal_of
from ..core.targets import HandleSpec
from ..core.transforms import nearest_rotations

MIRROR_TOLERANCE = 1e-4  # how far mirror images may be apart, as a fraction of the diagonal
FREE_SHARE = 0.4  # of the falloff, what is not held at all
LEAST_HOLD = 1e-3  # weights below hold nothing
MOST_IN_CELL = 64  # vertices that are looked at where the mesh is finer than the tolerance: time and memory are bounded

Signs = tuple[float, float, float]
"""A mirror image, object space: -1 for every axis that is turned round."""
ITSELF: Signs = (1.0, 1.0, 1.0)


@dataclass(frozen=True)
class Grab:
    """A piece of surface that is held, and dragged where a motion says so.

    Attributes:
        vertices: (k,) int32, ascending.
        reach: how far around it the mesh is free while nobody has set a pin, in world units; 0: somebody has set it.
        image: which mirror image of the piece under the mouse it is.
        planes: the mirror images that the piece under the mouse is itself: it lies on these planes.
    """

    vertices: Ints
    reach: float = 0.0
    image: Signs = ITSELF
    planes: tuple[Signs, ...] = ()

    def motion(self, grabbed: Floats, centre: Floats, stretch: Floats) -> Floats:
        """(4, 4) object-space motion of this piece.

        Args:
            grabbed: (4, 4) what the mouse wants of the piece under it, rigid as seen.
            centre: (3,) of the piece under the mouse, which stays on its planes.
            stretch: (3, 3) of the object.
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


def symmetric_grabs(rest: Floats, edges: Ints, vertices: Ints, reach: float, axes: Sequence[bool]) -> list[Grab]:
    """The piece under the mouse, joined with the mirror images that it touches, and then its other images.

    Args:
        rest: (n, 3) at rest, object space.
        edges: (e, 2).
        vertices: (k,) under the mouse.
        reach: see Grab.
        axes: whether x, y and z are mirrored.

    Raises:
        ValueError: most of these vertices have no mirror image; the message goes on from the object's name.
    """
    piece, planes = vertices, []
    for signs in mirror_signs(axes):
        image = mirror_images(rest, edges, vertices, signs)
        if 2 * len(image) < len(vertices):
            names = " and ".join(name for name, sign in zip("XYZ", signs, strict=True) if sign < 0.0)
            raise ValueError(f"is not symmetric here: turn off Mirror {names}")
        if np.isin(image, vertices).any():
            piece = np.union1d(piece, image).astype(np.int32)
            planes.append(signs)
    grabs = [Grab(piece, reach, ITSELF, tuple(planes))]
    taken = piece
    for signs in mirror_signs(axes):
        image = mirror_images(rest, edges, piece, signs)
        if not np.isin(image, taken).any():
            grabs.append(Grab(image, reach, signs, tuple(planes)))
            taken = np.union1d(taken, image)
    return grabs


def connected_within(points: Floats, edges: Ints, seeds: Ints, centre: Floats, radius: float) -> Ints:
    """(k,) int32 vertices within ``radius`` of ``centre`` that are joined to one of ``seeds`` by edges inside.

    The seed that is nearest to the centre where no seed is within: a mesh coarser than the radius still has something
    to take hold of.

    Args:
        points: (n, 3).
        edges: (e, 2).
        seeds: vertices of the face at the centre.
        centre: (3,).
        radius: straight distance.
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


def hold_of_rest(points: Floats, edges: Ints, grabs: Sequence[Grab]) -> HandleSpec:
    """Holds what is beyond the reach of all ``grabs``, softly from FREE_SHARE of it on.

    Args:
        points: (n, 3) at rest, as seen: so the same grabs always hold the same.
        edges: (e, 2).
        grabs: with a reach each.
    """
    weights = np.ones(len(points))
    for grab in grabs:
        centre = points[grab.vertices].mean(axis=0)
        radius = float(np.linalg.norm(points[grab.vertices] - centre, axis=1).max())
        free = connected_within(points, edges, grab.vertices, centre, radius + grab.reach)
        beyond = np.linalg.norm(points[free] - centre, axis=1) - radius
        share = np.clip((beyond / grab.reach - FREE_SHARE) / (1.0 - FREE_SHARE), 0.0, 1.0)
        weights[free] = np.minimum(weights[free], share * share * (3.0 - 2.0 * share))
        weights[grab.vertices] = 0.0
    held = np.flatnonzero(weights >= LEAST_HOLD).astype(np.int32)
    return HandleSpec("Rest", held, weights[held])


def mirror_signs(axes: Sequence[bool]) -> Iterator[Signs]:
    """The mirror images other than the thing itself, for the planes of these axes: 1, 3 or 7 of them."""
    choices = [(1.0, -1.0) if is_mirrored else (1.0,) for is_mirrored in axes]
    images = itertools.product(*choices)
    next(images)
    yield from images


def mirror_images(rest: Floats, edges: Ints, vertices: Ints, signs: Sequence[float]) -> Ints:
    """(m,) int32 ascending, the vertices at the mirror images of ``vertices``; those without one are left out.

    Of several vertices at one place (an open seam, surfaces that touch) it is the one joined to the most of the image.

    Args:
        rest: (n, 3) at rest.
        edges: (e, 2).
        vertices: (k,).
        signs: (3,) of 1 and -1.
    """
    rows, candidates, distances = _near(rest, rest[vertices] * np.asarray(signs), MIRROR_TOLERANCE * diagonal_of(rest))
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


def _near(rest: Floats, places: Floats, reach: float) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """Which vertices are within ``reach`` of which places: rows of ``places``, vertices, distances; (p,) each."""
    cell = 2.0 * reach
    lowest = rest.min(axis=0) - cell
    keys = _cell_keys(rest, lowest, cell)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    rows: list[NDArray[np.int64]] = [np.empty(0, dtype=np.int64)]
    candidates = rows.copy()
    # What is within reach lies in one of the cells that a box of that size touches.
    for corner in itertools.product((-0.5, 0.5), repeat=3):
        wanted = _cell_keys(places + cell * np.array(corner), lowest, cell)
        starts, ends = np.searchsorted(keys, wanted), np.searchsorted(keys, wanted, side="right")
        for step in range(min(MOST_IN_CELL, int((ends - starts).max(initial=0)))):
            row = np.flatnonzero(starts + step < ends).astype(np.int64)
            rows.append(row)
            candidates.append(order[starts[row] + step].astype(np.int64))
    all_rows, found = np.concatenate(rows), np.concatenate(candidates)
    distances: Floats = np.linalg.norm(rest[found] - places[all_rows], axis=1)
    is_near = distances <= reach
    return all_rows[is_near], found[is_near], distances[is_near]


def _cell_keys(points: Floats, lowest: Floats, cell: float) -> NDArray[np.int64]:
    cells = np.clip(np.floor((points - lowest) / cell), -1, 2**20 - 2).astype(np.int64) + 1
    return np.asarray((cells[:, 0] << 42) | (cells[:, 1] << 21) | cells[:, 2])
