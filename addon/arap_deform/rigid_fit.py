# SPDX-License-Identifier: GPL-3.0-or-later
"""The stretch in a matrix, and the rigid motion that fits two sets of points best. No bpy."""

from __future__ import annotations

import numpy as np

from .handle_map import Floats, nearest_rotations


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


def best_rigid_fit(rest: Floats, shown: Floats, stretch: Floats, weights: Floats | None = None) -> Floats:
    """(4, 4) object-space motion, rigid as seen, that takes (k, 3) ``rest`` nearest to (k, 3) ``shown``.

    It takes the average to the average, both weighted by ``weights``, (k,); None: all alike. Points on a line, or a
    single one, do not say all of the rotation: then it is the smallest.
    """
    rest_seen = rest @ stretch.T
    shown_seen = shown @ stretch.T
    rest_centre = np.average(rest_seen, axis=0, weights=weights)
    shown_centre = np.average(shown_seen, axis=0, weights=weights)
    from_centre = shown_seen - shown_centre
    covariance = (from_centre if weights is None else from_centre * weights[:, None]).T @ (rest_seen - rest_centre)
    # Leans what the points leave open towards no rotation.
    lean = 1e-9 * np.abs(covariance).max() or 1.0
    rotation = nearest_rotations((covariance + lean * np.eye(3))[None])[0]
    fit = np.eye(4)
    unstretch = np.linalg.inv(stretch)
    fit[:3, :3] = unstretch @ rotation @ stretch
    fit[:3, 3] = unstretch @ (shown_centre - rotation @ rest_centre)
    return fit
