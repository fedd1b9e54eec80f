# SPDX-License-Identifier: GPL-3.0-or-later
"""Between two poses of handles, and their mirror images, as motions since rest. No bpy.

A motion is what core.targets takes: (4, 4), from where a piece of the mesh is at rest to where it is. It is seen as a
rigid motion after a stretch about the handle's own place, T = G P. Rigid motions blend along the screw that takes one
to the other: the rotation turns the short way round, about an axis of its own, while it slides along that axis. So
pieces that go the same way together stay together all the way, as nothing is bent that need not be; a straight path
with a rotation beside it would cut the corner and shorten a swinging arm. Stretches blend by their logarithms: from 1
to 4 the middle is 2, and no shear comes in.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..core.arrays import Floats
from ..core.transforms import nearest_rotations

SMALLEST_ANGLE = 1e-7  # radians; below, a rotation is a straight move as far as doubles can tell
SMALLEST_STRETCH = 1e-6  # below, the stretch has no logarithm worth the name


def blended(
    names: Sequence[str], first: Floats, second: Floats, factor: float, pivots: Floats, stretch: Floats
) -> Floats:
    """(h, 4, 4) motions between ``first`` (factor 0) and ``second`` (factor 1), rigid as seen; beyond 0 and 1 too.

    Args:
        names: of the handles, for messages.
        first, second: (h, 4, 4) object-space motions.
        factor: 0 to 1, or a little beyond.
        pivots: (h, 3) where each handle is at rest, object space: what its stretch leaves where it is.
        stretch: (3, 3) stretch of the object as seen, see core.transforms.stretch_of().

    Raises:
        ValueError: a handle is flat or turned inside out in one of them: nothing is between that and the other.
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
    """(..., 4, 4) motions as a mirror across the plane ``axis`` = 0 shows them; rotations stay rotations."""
    signs = np.ones(4)
    signs[axis] = -1.0
    return np.asarray(motions * signs[:, None] * signs)


def partners(
    names: Sequence[str], flipped: Sequence[str], places: Floats, axis: int, reach: float, needed: set[int]
) -> dict[int, int]:
    """Index of the partner of each needed handle on the other side; its own where it is in the middle.

    The name decides where it has a side, ``Hand.L`` for example, and there is the other one; else the place at rest.

    Args:
        names: of all handles.
        flipped: their names with the side exchanged, the same where they have none.
        places: (h, 3) where the handles are at rest, object space.
        axis: 0, 1 or 2; the plane of symmetry is where this coordinate is 0.
        reach: how far from its mirrored place a partner may be.
        needed: indices of the handles to find partners for.

    Raises:
        ValueError: a handle has no partner, or one that has another partner.
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
                f"Handle '{names[i]}' has '{names[other]}' for its mirror image, but that one has '{names[back]}': "
                "give them names with sides, Hand.L and Hand.R for example"
            )
    return result


def _no_partner(name: str, flipped: str, axis: int) -> str:
    named = f"there is no handle '{flipped}', and none" if flipped != name else "there is no handle"
    return (
        f"Handle '{name}' has no partner on the other side of {'XYZ'[axis]} = 0: {named} at its mirrored place; "
        "add one, or choose another axis"
    )


def _between(first: Floats, second: Floats, factor: float, pivot: Floats) -> Floats:
    first_rigid, first_stretch = _rigid_and_log_stretch(first, pivot)
    second_rigid, second_stretch = _rigid_and_log_stretch(second, pivot)
    rigid = _powered(second_rigid @ _rigid_inverse(first_rigid), factor) @ first_rigid
    log_stretch = (1.0 - factor) * first_stretch + factor * second_stretch
    result = rigid.copy()
    result[:3, :3] = rigid[:3, :3] @ _exp_symmetric(log_stretch)
    result[:3, 3] += rigid[:3, :3] @ pivot - result[:3, :3] @ pivot
    return result


def _rigid_and_log_stretch(motion: Floats, pivot: Floats) -> tuple[Floats, Floats]:
    """G and log P of x -> G(P (x - pivot) + pivot)."""
    linear = motion[:3, :3]
    rotation = nearest_rotations(linear[None])[0]
    values, vectors = np.linalg.eigh(_symmetric(rotation.T @ linear))
    if values[0] <= SMALLEST_STRETCH * max(values[2], 1e-300):
        raise ValueError("is flat or turned inside out in one of the two poses: scale it back and store that pose anew")
    rigid = np.eye(4)
    rigid[:3, :3] = rotation
    rigid[:3, 3] = motion[:3, 3] + linear @ pivot - rotation @ pivot
    return rigid, (vectors * np.log(values)) @ vectors.T


def _powered(rigid: Floats, exponent: float) -> Floats:
    """The rigid motion ``exponent`` times, along its screw."""
    turn = _rotation_vector(rigid[:3, :3])
    result = np.eye(4)
    result[:3, :3] = _rotation(exponent * turn)
    # The move is V(turn) v with one and the same v for every part of the way: exp of the twist (turn, v).
    velocity = np.linalg.solve(_left_jacobian(turn), rigid[:3, 3])
    result[:3, 3] = _left_jacobian(exponent * turn) @ (exponent * velocity)
    return result


def _rotation_vector(rotation: Floats) -> Floats:
    """Axis times angle, the angle between 0 and pi."""
    quaternion = _quaternion(rotation)
    sine = float(np.linalg.norm(quaternion[1:]))
    if sine < SMALLEST_ANGLE:
        return np.asarray(2.0 * quaternion[1:])
    return np.asarray(quaternion[1:] * (2.0 * np.arctan2(sine, quaternion[0]) / sine))


def _quaternion(rotation: Floats) -> Floats:
    """(w, x, y, z) with w >= 0: the one of the two that turns the short way; exact also near half a turn."""
    r = rotation
    trace = np.trace(r)
    # Four times the products of each two components: the largest row is the quaternion up to its length.
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


def _rotation(turn: Floats) -> Floats:
    angle = float(np.linalg.norm(turn))
    k = _cross(turn)
    # sin(a)/a and (1 - cos(a))/a^2, which np.sinc knows at 0 too.
    half = np.sinc(angle / (2.0 * np.pi))
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * k + 0.5 * half * half * (k @ k))


def _left_jacobian(turn: Floats) -> Floats:
    """V with exp(twist) = (R, V v): the mean of all rotations on the way."""
    angle = float(np.linalg.norm(turn))
    k = _cross(turn)
    half = np.sinc(angle / (2.0 * np.pi))
    rest = 1.0 / 6.0 if angle < 1e-3 else (1.0 - np.sinc(angle / np.pi)) / angle**2
    return np.asarray(np.eye(3) + 0.5 * half * half * k + rest * (k @ k))


def _cross(v: Floats) -> Floats:
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def _rigid_inverse(rigid: Floats) -> Floats:
    result = np.eye(4)
    result[:3, :3] = rigid[:3, :3].T
    result[:3, 3] = -rigid[:3, :3].T @ rigid[:3, 3]
    return result


def _exp_symmetric(matrix: Floats) -> Floats:
    values, vectors = np.linalg.eigh(matrix)
    return np.asarray((vectors * np.exp(values)) @ vectors.T)


def _symmetric(matrix: Floats) -> Floats:
    return np.asarray(0.5 * (matrix + matrix.T))
