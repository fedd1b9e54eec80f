# SPDX-License-Identifier: GPL-3.0-or-later
"""A few vertices of an attached object and of its host: they tell quickly whether a bind still fits. No bpy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import Float32s, Floats
from ..transforms import are_same_places, transformed

MOST = 10  # vertices of each: to read them takes microseconds, and a property of Blender's takes 32 numbers


def probed(n: int) -> list[int]:
    """Numbers of the vertices that are looked at, of ``n``."""
    count = min(n, MOST)
    return [k * (n - 1) // max(count - 1, 1) for k in range(count)]


@dataclass(frozen=True, kw_only=True)
class Probe:
    """At rest.

    Attributes:
        points: (k, 3) float32 of the attached object, in its own space.
        surface: (l, 3) float32 of its host, in its own space.
        place: (4, 4) from the former space to the latter.
    """

    points: Float32s
    surface: Float32s
    place: Floats

    def is_same(self, other: Probe) -> bool:
        pairs = ((self.points, other.points), (self.surface, other.surface), (self.place, other.place))
        return all(np.array_equal(a, b) for a, b in pairs)

    def is_applied(self, now: Probe) -> bool:
        """Whether one of the objects, or both, got other coordinates that say the same: as by Object > Apply.

        Then nothing has moved as seen from the host, but for an affine map that its own vertices have followed.

        Args:
            now: of as many vertices. Its ``place`` is where the attached object is now.
        """
        before = np.column_stack([self.surface.astype(np.float64), np.ones(len(self.surface))])
        to_now = np.linalg.lstsq(before, now.surface.astype(np.float64), rcond=None)[0]
        points = transformed(self.place, self.points.astype(np.float64))
        expected = np.concatenate([before @ to_now, np.column_stack([points, np.ones(len(points))]) @ to_now])
        found = np.concatenate([now.surface, transformed(now.place, now.points.astype(np.float64))])
        return are_same_places(found, expected)
