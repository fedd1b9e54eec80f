# SPDX-License-Identifier: GPL-3.0-or-later
"""What a model gets that carries a mesh along with another one; contenders/followers.py runs it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from .contender import Floats, Ints


class Carried(NamedTuple):
    """A body, the shapes it takes, and a follower.

    Attributes:
        body, follower: (n, 3), (k, 3) at rest, in one space.
        body_corners, follower_corners: (c,) int32, the faces' vertices, one face after the other.
        body_sizes, follower_sizes: (f,) int32.
        shapes: (steps, n, 3) of the body.
    """

    body: Floats
    body_corners: Ints
    body_sizes: Ints
    follower: Floats
    follower_corners: Ints
    follower_sizes: Ints
    shapes: Floats


def write_carried(path: Path, carried: Carried) -> None:
    """As .npz, with the names of the attributes."""
    np.savez(path, **carried._asdict())


def read_carried(path: Path) -> Carried:
    """What write_carried wrote."""
    with np.load(path) as data:
        return Carried(**data)
