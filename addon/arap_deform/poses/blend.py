# SPDX-License-Identifier: GPL-3.0-or-later
"""Blends of two poses of handles, and mirror images of poses. No bpy.

A pose is a (4, 4) motion of each handle since rest, as core.targets takes it. It is split into a stretch P about the
handle's place at rest and a rigid motion G after it, T = G P.

Rigid motions blend along the screw from one to the other: a rotation by the smaller angle about an axis, and a slide
along this axis. So handles that move together stay together, and a swinging arm keeps its length. A straight path would
shorten it. Stretches blend by their logarithms: half way from 1 to 4 is 2. This adds no shear.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core.arrays import Floats
from ..core.transforms import cross_matrix, nearest_rotations, rotation

SMALLEST_ANGLE = 1e-7  # radians; in double precision, a motion with a smaller rotation is a straight move
SMALLEST_STRETCH = 1e-6  # the smallest stretch, relative to the largest, that has a usable logarithm


def blended(
    names: Sequence[str], first: Floats, second: Floats, factor: float, pivots: Floats, stretch: Floats
) -> Floats:
    """(h, 4, 4) motions between ``first`` (factor 0) and ``second`` (factor 1), rigid as seen.

    Args:
        names: of the handles, for messages.
        first, second: (h, 4, 4) object-space motions.
        factor: 0 to 1, or a little beyond.
        pivots: (h, 3) places of the handles at rest, object space: the stretch of a handle keeps its pivot in place.
        stretch: (3, 3) stretch of the object, see core.transforms.stretch_of().

    Raises:
        ValueError: a handle is flat or turned inside out in one of the poses.
    """
    to_seen, from_seen = np.eye(4), np.eye(4)
    to_seen[:3, :3], from_seen[:3, :3] = stretch, np.linalg.inv(stretch)
    result = np.empty_like(first)
    for i, name in enumerate(names):
        pivot = stretch @ pivots[i]
        try:
            seen = _between(to_seen @ first[i] @ from_seen, to_seen @ second[i] @ from_seen, factor, pivot)
        except ValueError as error:
            raise ValueError(f"Handle '{name}' {error}") from None
        result[i] = from_seen @ seen @ to_seen
    return result


def mirrored(motions: Floats, axis: int) -> Floats:
    """(..., 4, 4) mirror images of motions in the plane ``axis`` = 0; rotations stay rotations."""
    signs = np.ones(4)
    signs[axis] = -1.0
    return np.asarray(motions * signs[:, None] * signs)


def partners(
    names: Sequence[str], flipped: Sequence[str], places: Floats, axis: int, reach: float, needed: set[int]
) -> dict[int, int]:
    """The index of the partner on the other side, for each needed handle; a handle in the middle is its own partner.

    If the name has a side, as in ``Hand.L``, and a handle has the name with the other side, that is the partner. Else
    it is the handle at the mirrored place.

    Args:
        names: of all handles.
        flipped: the names with the other side; unchanged if they have no side.
        places: (h, 3) of the handles at rest, object space.
        axis: 0, 1 or 2; the plane of symmetry has this coordinate 0.
        reach: largest distance of a partner from the mirrored place.
        needed: indices of the handles that need a partner.

    Raises:
        ValueError: a handle has no partner, or its partner has another one.
    """
    index_of = {name: i for i, name in enumerate(names)}
    image = places.copy()
    image[:, axis] *= -1.0

    def partner(i: int) -> int:
        if flipped[i] != names[i] and flipped[i] in index_of:
            return index_of[flipped[i]]
        distance = np.linalg.norm(places - image[i], axis=1)
        nearest = int(distance.argmin())
        if distance[nearest] > reach:
            raise ValueError(_no_partner(names[i], flipped[i], axis))
        return nearest

    result = {i: partner(i) for i in sorted(needed)}
    for i, other in result.items():
        back = partner(other)
        if back != i:
            raise ValueError(
                f"The mirror image of handle '{names[i]}' is '{names[other]}', but the mirror image of "
                f"'{names[other]}' is '{names[back]}': give them names with sides, for example Hand.L and Hand.R"
            )
    return result


def _no_partner(name: str, flipped: str, axis: int) -> str:
    named = f"named '{flipped}' or " if flipped != name else ""
    return (
        f"Handle '{name}' has no partner on the other side of {'XYZ'[axis]} = 0: "
        f"add a handle {named}at its mirrored place, or choose another axis"
    )


def _between(first: Floats, second: Floats, factor: float, pivot: Floats) -> Floats:
    first_rigid, first_stretch = _rigid_and_log_stretch(first, pivot)
    second_rigid, second_stretch = _rigid_and_log_stretch(second, pivot)
    rigid = _powered(second_rigid @ np.linalg.inv(first_rigid), factor) @ first_rigid
    logs, vectors = np.linalg.eigh((1.0 - factor) * first_stretch + factor * second_stretch)
    result = rigid.copy()
    result[:3, :3] = rigid[:3, :3] @ (vectors * np.exp(logs)) @ vectors.T
    result[:3, 3] += rigid[:3, :3] @ pivot - result[:3, :3] @ pivot
    return result


def _rigid_and_log_stretch(motion: Floats, pivot: Floats) -> tuple[Floats, Floats]:
    """G and log P of x -> G(P (x - pivot) + pivot)."""
    linear = motion[:3, :3]
    nearest = nearest_rotations(linear[None])[0]
    stretch = nearest.T @ linear
    values, vectors = np.linalg.eigh(0.5 * (stretch + stretch.T))  # symmetric but for rounding
    if values[0] <= SMALLEST_STRETCH * max(values[2], 1e-300):
        raise ValueError("is flat or turned inside out in one of the poses: scale it back and store that pose again")
    rigid = np.eye(4)
    rigid[:3, :3] = nearest
    rigid[:3, 3] = motion[:3, 3] + linear @ pivot - nearest @ pivot
    return rigid, (vectors * np.log(values)) @ vectors.T


def _powered(rigid: Floats, exponent: float) -> Floats:
    """The part ``exponent`` of a rigid motion, along its screw."""
    turn = _rotation_vector(rigid[:3, :3])
    result = np.eye(4)
    result[:3, :3] = rotation(exponent * turn)
    # The motion is exp of the twist (turn, velocity): its shift is V(turn) velocity, with one velocity on all the way.
    velocity = np.linalg.solve(_left_jacobian(turn), rigid[:3, 3])
    result[:3, 3] = _left_jacobian(exponent * turn) @ (exponent * velocity)
    return result


def _rotation_vector(matrix: Floats) -> Floats:
    """Axis times angle, with the angle between 0 and pi."""
    quaternion = _quaternion(matrix)
    sine = float(np.linalg.norm(quaternion[1:]))
    if sine < SMALLEST_ANGLE:
        return np.asarray(2.0 * quaternion[1:])
    return np.asarray(quaternion[1:] * (2.0 * np.arctan2(sine, quaternion[0]) / sine))


def _quaternion(r: Floats) -> Floats:
    """(w, x, y, z) with w >= 0, so that it turns by the smaller angle; exact also near half a turn."""
    trace = np.trace(r)
    # Four times the products of any two components: each row is a multiple of the quaternion.
    products = np.array(
        [
            [1.0 + trace, r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], 1.0 + 2.0 * r[0, 0] - trace, r[0, 1] + r[1, 0], r[0, 2] + r[2, 0]],
            [r[0, 2] - r[2, 0], r[0, 1] + r[1, 0], 1.0 + 2.0 * r[1, 1] - trace, r[1, 2] + r[2, 1]],
            [r[1, 0] - r[0, 1], r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], 1.0 + 2.0 * r[2, 2] - trace],
        ]
    )
    row = products[int(products.diagonal().argmax())]
    quaternion = row / np.linalg.norm(row)
    return np.asarray(-quaternion if quaternion[0] < 0.0 else quaternion)


def _left_jacobian(turn: Floats) -> Floats:
    """V with exp(twist) = (R, V velocity): the mean of all rotations on the way."""
    angle = float(np.linalg.norm(turn))
    k = cross_matrix(turn)
    half = np.sinc(angle / (2.0 * np.pi))
    rest = 1.0 / 6.0 if angle < 1e-3 else (1.0 - np.sinc(angle / np.pi)) / angle**2
    return np.asarray(np.eye(3) + 0.5 * half * half * k + rest * (k @ k))
