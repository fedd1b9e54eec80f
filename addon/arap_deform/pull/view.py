# SPDX-License-Identifier: GPL-3.0-or-later
"""A 3D view as the mouse sees it. No bpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Floats

Pixels = Sequence[float] | NDArray[np.float64]


@dataclass(frozen=True)
class View:
    """A 3D view as the mouse sees it.

    Attributes:
        perspective: (4, 4) from the world to clip space, of perspective and orthographic views alike.
        size: of the region in pixels; pixels count from its lower left corner.
    """

    perspective: Floats
    size: tuple[int, int]

    def pixels(self, points: Floats) -> Floats:
        """(k, 2) pixels of (k, 3) points in the world; NaN behind the viewer."""
        clip = points @ self.perspective[:, :3].T + self.perspective[:, 3]
        width = np.where(clip[:, 3:] > 0.0, clip[:, 3:], np.nan)
        return np.asarray((clip[:, :2] / width + 1.0) * 0.5 * np.array(self.size))

    def ray(self, pixel: Pixels) -> tuple[Floats, Floats]:
        """Origin, on the near plane, and unit direction of the line of sight of a pixel."""
        near, far = self._unproject(pixel, -1.0), self._unproject(pixel, 1.0)
        return near, (far - near) / np.linalg.norm(far - near)

    def at_depth_of(self, point: Floats, pixel: Pixels) -> Floats:
        """(3,) the point at a pixel in the plane through ``point`` that faces the viewer."""
        clip = self.perspective @ np.append(point, 1.0)
        return self._unproject(pixel, float(clip[2] / clip[3]))

    def pixel_steps(self, point: Floats) -> tuple[Floats, Floats]:
        """(3,) steps in the world of one pixel to the right and one up, at the depth of ``point``."""
        x, y = self.pixels(point[None])[0]
        here = self.at_depth_of(point, (x, y))
        return self.at_depth_of(point, (x + 1.0, y)) - here, self.at_depth_of(point, (x, y + 1.0)) - here

    def pixel_size(self, point: Floats) -> float:
        """Length of a pixel in the world, at the depth of ``point``."""
        return float(np.linalg.norm(self.pixel_steps(point)[0]))

    def towards_viewer(self, point: Floats) -> Floats:
        """(3,) unit normal of the plane through ``point`` that faces the viewer."""
        right, up = self.pixel_steps(point)
        normal = np.cross(right, up)
        return np.asarray(normal / np.linalg.norm(normal))

    def _unproject(self, pixel: Pixels, depth: float) -> Floats:
        across = 2.0 * np.asarray(pixel, dtype=np.float64) / np.array(self.size) - 1.0
        point = self._to_world @ np.array([*across, depth, 1.0])
        return np.asarray(point[:3] / point[3])

    @cached_property
    def _to_world(self) -> Floats:
        """(4, 4), found once a drag: numpy.linalg wakes all threads of its BLAS library."""
        return np.asarray(np.linalg.inv(self.perspective))
