# SPDX-License-Identifier: GPL-3.0-or-later
"""From the mouse to motions in the world: the projection of a view, and the motion of a drag. No bpy."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np
from numpy.typing import NDArray

from ..core.arrays import Floats
from ..core.transforms import rotation

TURN_PER_PIXEL = np.pi / 360.0  # a drag of 180 pixels is a quarter turn
ALONG_THE_VIEW = 0.15  # sine between an axis and the line of sight below which the mouse cannot follow along the axis

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
        point = np.linalg.solve(self.perspective, np.array([*across, depth, 1.0]))
        return np.asarray(point[:3] / point[3])


def within(motion: Floats, place: Floats, pivot: Floats, length: float) -> Floats:
    """(4, 4) the motion, shifted so that it moves ``place`` no farther from ``pivot`` than the length or its distance.

    Args:
        motion: (4, 4).
        place, pivot: (3,).
    """
    offset = motion[:3, :3] @ place + motion[:3, 3] - pivot
    distance, most = float(np.linalg.norm(offset)), max(length, float(np.linalg.norm(place - pivot)))
    if distance <= most:
        return motion
    shifted = motion.copy()
    shifted[:3, 3] += offset * (most / distance - 1.0)
    return shifted


class Mode(Enum):
    """What a drag does."""

    MOVE = auto()  # in the plane that faces the viewer, or along an axis
    TURN = auto()  # about the line of sight, or about an axis
    NORMAL = auto()  # along the normal of the surface


class Drag:
    """The rigid motion of a drag, from the place of the mouse.

    A change of mode keeps the motion of the former mode. A change of axis replaces the motion of the present mode.
    """

    def __init__(self, view: View, mouse: Pixels, place: Floats, normal: Floats) -> None:
        """Begins.

        Args:
            view: at the begin of the drag.
            mouse: pixel where the drag begins.
            place: (3,) world, the point that is dragged and turned about.
            normal: (3,) unit normal of the surface there, world space.
        """
        self._view = view
        self._place = place
        self._normal = normal
        self._before = np.eye(4)
        self._from = self._mouse = np.asarray(mouse, dtype=np.float64)
        self.mode = Mode.MOVE
        self.axis: int | None = None

    def to(self, mouse: Pixels) -> None:
        self._mouse = np.asarray(mouse, dtype=np.float64)

    def set_mode(self, mode: Mode) -> None:
        if mode is not self.mode:
            self._before = self.motion
            self._from = self._mouse
            self.mode = mode

    def toggle_axis(self, axis: int) -> None:
        """Constrains to the world axis 0, 1 or 2; the same axis again removes the constraint."""
        self.axis = None if axis == self.axis else axis

    @property
    def place(self) -> Floats:
        """(3,) present place of the dragged point, world."""
        motion = self.motion
        return np.asarray(motion[:3, :3] @ self._place + motion[:3, 3])

    @property
    def motion(self) -> Floats:
        """(4, 4) rigid motion in the world since the begin of the drag."""
        start = self._before[:3, :3] @ self._place + self._before[:3, 3]
        now = np.eye(4)
        if self.mode is Mode.TURN:
            axis = self._view.towards_viewer(start) if self.axis is None else np.eye(3)[self.axis]
            turn = rotation(axis * (TURN_PER_PIXEL * float(self._from[0] - self._mouse[0])))
            now[:3, :3] = turn
            now[:3, 3] = start - turn @ start
        else:
            now[:3, 3] = self._shift(start)
        return np.asarray(now @ self._before)

    def _shift(self, start: Floats) -> Floats:
        if self.mode is Mode.NORMAL:
            normal = self._before[:3, :3] @ self._normal
            return np.asarray(normal * self._upwards(start))
        if self.axis is not None:
            return self._along(start, np.eye(3)[self.axis])
        before = self._view.at_depth_of(start, self._from)
        return np.asarray(self._view.at_depth_of(start, self._mouse) - before)

    def _upwards(self, start: Floats) -> float:
        return self._view.pixel_size(start) * float(self._mouse[1] - self._from[1])

    def _along(self, start: Floats, axis: Floats) -> Floats:
        """The shift along the axis that follows the mouse."""
        places = []
        for pixel in (self._from, self._mouse):
            # The place need not be under the mouse: only the difference of the two rays counts.
            origin, direction = self._view.ray(pixel)
            across = direction - axis * float(direction @ axis)
            if np.linalg.norm(across) < ALONG_THE_VIEW:
                return np.asarray(axis * self._upwards(start))
            # The point of the line through start that is nearest to the ray.
            apart = origin - start
            places.append(float(apart @ axis - (direction @ axis) * (apart @ across) / (across @ across)))
        return np.asarray(axis * (places[1] - places[0]))
