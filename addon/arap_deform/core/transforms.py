# SPDX-License-Identifier: GPL-3.0-or-later
"""Linear maps of points, the stretch in a matrix, the nearest rotation, the rigid motion that fits, Blender's Apply."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Floats

# Rows of a product. For larger ones numpy's BLAS takes all its threads, which then wait for the next one by spinning:
# for tens of milliseconds they hold the cores that the solver needs at once (up to a third of a frame on two cores).
BLOCK = 8192


MOST_NEWTON_STEPS = 12
NEWTON_ENDS = 1e-8  # its next step would be the square of that

SAME = 1e-5  # of coordinates: what single precision leaves of them after Blender's Apply

IDENTITY = (1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0)
"""A 4x4 matrix, row by row, as Blender's properties save it."""

TOO_FAR = (
    "Some vertices would be too far away for single precision, so the pose is as it was: "
    "bring the handles nearer to the mesh, or apply its scale"
)


def transformed(matrix: Floats, points: NDArray[np.floating]) -> Floats:
    """(k, 3) ``points``, or a single one, moved by a (4, 4) matrix."""
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])


def inverted(matrices: NDArray[np.floating]) -> Floats:
    """(..., 4, 4) inverses of affine (..., 4, 4) matrices, on one thread: numpy.linalg wakes all of its BLAS library's.

    Raises:
        LinAlgError: one is singular.
    """
    linear = np.moveaxis(np.asarray(matrices, dtype=np.float64)[..., :3, :3], (-2, -1), (0, 1))
    cofactors = _cofactors(linear)
    determinants = (linear[0] * cofactors[0]).sum(axis=0)
    if (determinants == 0.0).any():
        raise np.linalg.LinAlgError("Singular matrix")
    result = np.zeros(np.shape(matrices))
    result[..., :3, :3] = np.moveaxis(cofactors / determinants, (1, 0), (-2, -1))
    result[..., :3, 3] = -np.einsum("...ij,...j->...i", result[..., :3, :3], matrices[..., :3, 3])
    result[..., 3, 3] = 1.0
    return result


def map_points(points: NDArray[Any], linear: NDArray[Any], out: NDArray[Any]) -> None:
    """Writes points @ linear.T, on one thread.

    Args:
        points: (n, 3) contiguous.
        linear: (3, 3) of the same dtype.
        out: as points, and not them.

    Raises:
        ValueError: ``out`` is not contiguous.
    """
    if not out.flags.c_contiguous:
        raise ValueError("The mapped points need an array of their own: make it contiguous")
    whole = len(points) // BLOCK * BLOCK
    blocks = (-1, BLOCK, 3)
    np.matmul(points[:whole].reshape(blocks), linear.T, out=out[:whole].reshape(blocks))
    np.matmul(points[whole:], linear.T, out=out[whole:])


def nearest_rotations(matrices: Floats) -> Floats:
    """(..., 3, 3) nearest proper rotations of (..., 3, 3) matrices."""
    u, _, vt = np.linalg.svd(matrices)
    flip = np.linalg.det(u @ vt) < 0.0
    u[flip, :, 2] *= -1.0
    return np.asarray(u @ vt)


def fitted_rotations(covariances: Floats) -> Floats:
    """(k, 3, 3) rotations that fit best, for the sums of the products of places and rest places from their centres.

    Points on a line, or a single one, do not say all of the rotation: then it is the smallest.
    """
    # Newton's iteration to the polar factor takes an eighth of the time of singular values. With its cofactors added a
    # matrix keeps its singular vectors: flat sets of points then have a third one, and nothing becomes its mirror.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        x = np.moveaxis(covariances, (-2, -1), (0, 1))
        x = x / np.sqrt((x * x).sum(axis=(0, 1)))
        x = x + _cofactors(x)
        for _ in range(MOST_NEWTON_STEPS):
            cofactors = _cofactors(x)
            former, x = x, 0.5 * (x + cofactors / (x[0] * cofactors[0]).sum(axis=0))
            if np.abs(x - former).max() <= NEWTON_ENDS:
                break
        has_ended = np.isfinite(x).all(axis=(0, 1)) & (np.abs(x - _cofactors(x)).max(axis=(0, 1)) <= NEWTON_ENDS)
    rotations = np.array(np.moveaxis(x, (0, 1), (-2, -1)))
    left = covariances[~has_ended]
    # Leans what the points leave open towards no rotation.
    lean = 1e-9 * np.abs(left).max(axis=(-2, -1), keepdims=True)
    rotations[~has_ended] = nearest_rotations(left + np.where(lean > 0.0, lean, 1.0) * np.eye(3))
    return rotations


def _cofactors(x: Floats) -> Floats:
    """(3, 3, ...) of matrices (3, 3, ...). A rotation has those of itself."""
    below, below_that = x[[1, 2, 0]], x[[2, 0, 1]]
    ahead, ahead_of_that = [1, 2, 0], [2, 0, 1]
    return below[:, ahead] * below_that[:, ahead_of_that] - below[:, ahead_of_that] * below_that[:, ahead]


def cross_matrix(turn: Floats) -> Floats:
    """(3, 3) K with K x = turn cross x."""
    x, y, z = turn
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def rotation(turn: Floats) -> Floats:
    """(3, 3) rotation by the (3,) rotation vector ``turn``: axis times angle in radians, right-handed."""
    angle = float(np.linalg.norm(turn))
    cross = cross_matrix(turn)
    # sin(a) / a and (1 - cos(a)) / a^2, by np.sinc because it is exact at 0.
    half = np.sinc(angle / (2.0 * np.pi))
    return np.asarray(np.eye(3) + np.sinc(angle / np.pi) * cross + 0.5 * half * half * (cross @ cross))


def stretch_of(matrix: Floats) -> Floats:
    """(3, 3) symmetric positive factor S of matrix = R S, for the 3x3 or 4x4 ``matrix``.

    Raises:
        ValueError: not finite, or singular: something is flat as seen, and its rest shape is lost.
    """
    linear = np.asarray(matrix, dtype=np.float64)[:3, :3]
    if not np.isfinite(linear).all():
        raise ValueError("has a transform that is not finite: reset it")
    _, sigma, vt = np.linalg.svd(linear)
    if sigma[2] <= 1e-6 * sigma[0]:
        raise ValueError("is scaled to nothing along an axis: give it a scale")
    if np.abs(sigma - 1.0).max() <= 1e-6:
        return np.eye(3)  # Blender's rotations are single precision; a stretch of 1 + 1e-7 means none
    return np.asarray((vt.T * sigma) @ vt)


def has_no_inverse(matrix: Floats) -> bool:
    """Whether a (4, 4) matrix is not finite, or flattens what it maps."""
    try:
        stretch_of(matrix)
    except ValueError:
        return True
    return False


def best_rigid_fit(rest: Floats, shown: Floats, stretch: Floats, weights: Floats | None = None) -> Floats:
    """(4, 4) object-space motion, rigid as seen, that takes (k, 3) ``rest`` nearest to (k, 3) ``shown``.

    It takes the average to the average, both weighted by ``weights``, (k,); None: all alike. See fitted_rotations().
    """
    rest_seen = rest @ stretch.T
    shown_seen = shown @ stretch.T
    rest_centre = np.average(rest_seen, axis=0, weights=weights)
    shown_centre = np.average(shown_seen, axis=0, weights=weights)
    from_centre = shown_seen - shown_centre
    covariance = (from_centre if weights is None else from_centre * weights[:, None]).T @ (rest_seen - rest_centre)
    rotation = fitted_rotations(covariance[None])[0]
    fit = np.eye(4)
    unstretch = np.linalg.inv(stretch)
    fit[:3, :3] = unstretch @ rotation @ stretch
    fit[:3, 3] = unstretch @ (shown_centre - rotation @ rest_centre)
    return fit


def are_same_places(found: NDArray[np.floating], expected: Floats) -> bool:
    """Whether (k, 3) places, of at least one point, are the expected ones, but for what Blender's Apply rounds."""
    return bool(np.abs(found - expected).max() <= SAME * np.abs(found).max())


def applied_map(
    matrix: Floats, points: NDArray[np.floating], matrix_now: Floats, points_now: NDArray[np.floating]
) -> Floats | None:
    """(4, 4) from former coordinates of an object to the present ones, if it stands where it stood, else None.

    So it is after Blender's Object > Apply, and Set Origin.

    Args:
        matrix, matrix_now: (4, 4) of the object.
        points, points_now: (k, 3) of some vertices of it.
    """
    if np.array_equal(points, points_now):
        return None  # at most, the object has moved
    try:
        to_now: Floats = np.asarray(inverted(matrix_now) @ matrix)
    except np.linalg.LinAlgError:
        return None
    with np.errstate(invalid="ignore", over="ignore"):  # of places that are not finite
        return to_now if are_same_places(points_now, transformed(to_now, points.astype(np.float64))) else None


class SolverSpace:
    """Where a model works: object space times a stretch. There rigid means rigid as seen.

    Attributes:
        stretch, unstretch: (3, 3) float64, symmetric, and its inverse.
    """

    def __init__(self, stretch: Floats) -> None:
        """``stretch``: see stretch_of()."""
        self.stretch = np.ascontiguousarray(stretch, dtype=np.float64)
        self.unstretch: Floats = np.asarray(np.linalg.inv(self.stretch), dtype=np.float64)
        self.is_stretched = not np.array_equal(self.stretch, np.eye(3))

    def to_solver(self, positions: Floats) -> Floats:
        """(n, 3) contiguous, for (n, 3) of object space."""
        return np.ascontiguousarray(positions @ self.stretch.T if self.is_stretched else positions)

    def show(self, solved: NDArray[np.float32], positions: NDArray[np.float32]) -> None:
        """Writes (n, 3) ``solved`` of solver space to ``positions`` of object space.

        Raises:
            RuntimeError: single precision does not reach that far; nothing is written.
        """
        farthest = max(solved.max(), -solved.min())
        in_object = float(farthest) * np.abs(self.unstretch).sum(axis=1).max()
        if not in_object <= np.finfo(np.float32).max:  # also what is not a number
            raise RuntimeError(TOO_FAR)
        if self.is_stretched:
            map_points(solved, self.unstretch.astype(np.float32), positions)
        else:
            positions[...] = solved
