# SPDX-License-Identifier: GPL-3.0-or-later
"""The motion of a drag in the world, from the place of the mouse. No bpy."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from ..core.arrays import Floats
from ..core.transforms import rotation
from .view import Pixels, View

TURN_PER_PIXEL = np.pi / 360.0  # a drag of 180 pixels is a quarter turn
LEAST_LEVER_PX = 20.0  # a piece nearer to its pivot, as seen, turns by TURN_PER_PIXEL
FAR_PIXELS = 16  # between a press and the first move after it
ALONG_THE_VIEW = 0.15  # sine between an axis and the line of sight below which the mouse cannot follow along the axis


def press_place(
    told: tuple[int, int], before: tuple[int, int], first_move: tuple[int, int], *, is_behind: bool
) -> tuple[int, int]:
    """Where the mouse was pressed. If Blender was busy, the press tells where the mouse was when it was read.

    Args:
        told: by the press.
        before: where the mouse had been before the press.
        first_move: the place of the first move after it.
        is_behind: whether further moves had come by then.
    """
    nearest = min(told, before, key=lambda place: math.dist(place, first_move))
    return first_move if is_behind and math.dist(nearest, first_move) > FAR_PIXELS else nearest


@dataclass(frozen=True)
class Lever:
    """What the dragged piece hangs on.

    Attributes:
        pivot: (3,) world, the joint of its limb.
        length: from there to the piece, as far as it reaches.
    """

    pivot: Floats
    length: float


class Mode(Enum):
    """What a drag does."""

    MOVE = auto()  # in the plane that faces the viewer, or along an axis
    TURN = auto()  # about the line of sight, or about an axis
    NORMAL = auto()  # along the normal of the surface


class Drag:
    """The rigid motion of a drag, from the place of the mouse.

    A change of mode keeps the motion of the former mode. A change of axis replaces the motion of the present mode.
    """

    def __init__(self, view: View, mouse: Pixels, place: Floats, normal: Floats, lever: Lever | None = None) -> None:
        """Begins.

        Args:
            view: at the begin of the drag.
            mouse: pixel where the drag begins.
            place: (3,) world, the point that is dragged and turned about.
            normal: (3,) unit normal of the surface there, world space.
            lever: None: the piece is on no limb. Then it goes with the mouse, keeps its angle, and turns about itself.
        """
        self._view = view
        self._place = place
        self._normal = normal
        self._before = np.eye(4)
        self._from = self._mouse = np.asarray(mouse, dtype=np.float64)
        self.mode = Mode.MOVE
        self.lever = lever
        self.is_turning_along = True  # with the limb, as it swings about its joint
        self.is_stretching = False  # the piece goes farther from its pivot than it reaches
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
        start = self._start
        now = np.eye(4)
        if self.mode is Mode.TURN:
            turn, pivot = self._turn(start), self.pivot
            now[:3, :3] = turn
            now[:3, 3] = pivot - turn @ pivot
        else:
            end = self._reached(start + self._shift(start))
            turn = self._swing(start, end)
            now[:3, :3] = turn
            now[:3, 3] = end - turn @ start
        return np.asarray(now @ self._before)

    @property
    def pivot(self) -> Floats:
        """(3,) what Mode.TURN turns about."""
        return self._start if self.lever is None else self.lever.pivot

    @property
    def wanted(self) -> Floats:
        """(3,) where the mouse would have the dragged point. It is there unless the limb is too short."""
        return self.place if self.mode is Mode.TURN else self._start + self._shift(self._start)

    @property
    def is_beyond(self) -> bool:
        """Whether the mouse is farther away than the limb reaches."""
        if self.mode is Mode.TURN:
            return False
        wanted = self.wanted
        return self._reached(wanted) is not wanted

    @property
    def _start(self) -> Floats:
        """(3,) where the dragged point was when the present mode began."""
        return np.asarray(self._before[:3, :3] @ self._place + self._before[:3, 3])

    def _turn(self, start: Floats) -> Floats:
        """(3, 3) so that the dragged point goes the way of the mouse."""
        axis = self._view.towards_viewer(start) if self.axis is None else np.eye(3)[self.axis]
        step = np.cross(axis, start - self.pivot)  # of the point, a radian
        way = np.stack(self._view.pixel_steps(start)) @ step / self._view.pixel_size(start) ** 2  # the same in pixels
        moved = self._mouse - self._from
        if np.linalg.norm(way) < LEAST_LEVER_PX:
            return rotation(axis * (-TURN_PER_PIXEL * float(moved[0])))
        if self.axis is not None:
            return rotation(axis * float(moved @ way / (way @ way)))
        before, after = (pixel - self._view.pixels(self.pivot[None])[0] for pixel in (self._from, self._mouse))
        swept = np.arctan2(before[0] * after[1] - before[1] * after[0], before @ after)
        return rotation(axis * float(swept))

    def _reached(self, end: Floats) -> Floats:
        """(3,) the end, or as far towards it as the limb reaches. It reaches where it was taken, however long it is."""
        if self.lever is None or self.is_stretching:
            return end
        pivot = self.lever.pivot
        distance = float(np.linalg.norm(end - pivot))
        most = max(self.lever.length, float(np.linalg.norm(self._start - pivot)))
        return end if distance <= most else np.asarray(pivot + (end - pivot) * (most / distance))

    def _swing(self, start: Floats, end: Floats) -> Floats:
        """(3, 3) the shortest turn about the pivot that leads from the start to the end, less of it near the pivot."""
        if self.lever is None or not self.is_turning_along:
            return np.eye(3)
        before, after = start - self.lever.pivot, end - self.lever.pivot
        across, along = np.cross(before, after), float(before @ after)
        sine = float(np.linalg.norm(across))
        if sine == 0.0:
            return np.eye(3)
        nearness = min(1.0, float(np.linalg.norm(after) / np.linalg.norm(before)))
        return rotation(across * (np.arctan2(sine, along) / sine * nearness))

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
