# SPDX-License-Identifier: GPL-3.0-or-later
"""What the figure has at its head: eyes, a mouth and brows, and hair of many cards; needs numpy alone."""

from __future__ import annotations

from itertools import pairwise
from math import pi
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .cage import Cage, ellipse
from .figure import HEAD_CENTRE
from .quad_mesh import Floats, Ints, QuadMesh

NEAR = 0.10  # radians: what counts of the head for a place on it

# Places on the face are two angles, to its left and down; 0, 0 is straight ahead of the middle of the head.
EYE_PLACE, EYE_RADIUS = (0.35, 0.06), 0.068
EYE_SUNK = 0.62  # of its radius is inside the head
EYE_AHEAD = 0.4  # how much the eyes look straight ahead instead of away from the middle of the head
WHITE, IRIS, PUPIL = range(3)
EYE_RINGS = (  # angle from where the eye looks, what is behind the ring
    (0.33, IRIS), (0.50, IRIS),
    (0.64, WHITE), (1.00, WHITE), (1.35, WHITE), (1.70, WHITE), (2.10, WHITE), (2.60, WHITE),
)  # fmt: skip

SMILE = ((-0.26, 0.40), (0.0, 0.60), (0.26, 0.40))
LEFT_BROW = ((0.21, -0.225), (0.34, -0.275), (0.48, -0.215))
RIGHT_BROW = ((-0.48, -0.215), (-0.34, -0.275), (-0.21, -0.225))
ROLL = 0.0115  # half width of these

HAIR_COLOR = (0.22, 0.075, 0.022)
N_ROWS, N_COLUMNS = 12, 5  # of a card
LAYERS = (  # cards, angle from the crown where they begin, how much earlier they end, distance from the head
    (24, 0.30, 0.0, 0.012),
    (22, 0.03, 0.22, 0.022),
)
CARD_WIDTH = 0.3  # radians, to each side
TIP_LIFT, RIDGE = 0.022, 0.006  # how much farther from the head the tip and the middle of a card are
CROWN = (0.0, 0.25, 1.0)
SWIRL = 0.45  # radians, of a card around the crown


def reach(body: QuadMesh, directions: Floats) -> Floats:
    """(n,) how far from the middle of the head its surface is, in unit directions (n, 3)."""
    offsets = body.positions[body.positions[:, 2] > 1.2] - HEAD_CENTRE
    lengths = np.linalg.norm(offsets, axis=1)
    weights = np.exp((directions @ (offsets / lengths[:, None]).T - 1.0) * 2.0 / NEAR**2)
    return np.asarray(weights @ lengths / weights.sum(axis=1))


def facing(left: Floats | float, down: Floats | float) -> Floats:
    """(n, 3) unit directions from the middle of the head to places on the face."""
    left, down = np.broadcast_arrays(left, down)
    return np.stack([np.sin(left) * np.cos(down), -np.cos(left) * np.cos(down), -np.sin(down)], axis=-1)


def eyes(body: QuadMesh) -> QuadMesh:
    """Two balls; face data "tag" is WHITE, IRIS or PUPIL."""
    out = facing(*EYE_PLACE)
    middle = HEAD_CENTRE + (reach(body, out[None])[0] - EYE_SUNK * EYE_RADIUS) * out
    axis = _unit((1.0 - EYE_AHEAD) * out + EYE_AHEAD * facing(0.0, 0.0))
    right = _unit(np.cross(axis, [0.0, 0.0, 1.0]))
    up = np.cross(right, axis)
    cage, loops = Cage(), []
    for angle, _ in EYE_RINGS[::-1]:
        radius = EYE_RADIUS * np.sin(angle)
        loops.append(cage.loop(ellipse(middle + EYE_RADIUS * np.cos(angle) * axis, radius * up, radius * right, n=24)))
    for (lower, upper), (_, tag) in zip(pairwise(loops), EYE_RINGS[-2::-1], strict=True):
        cage.tag = tag
        cage.loft(lower, upper)
    cage.tag = WHITE
    cage.cap(loops[0][::-1], middle - EYE_RADIUS * axis)
    cage.tag = PUPIL
    cage.cap(loops[-1], middle + EYE_RADIUS * axis)
    return cage.mirrored()


def smile(body: QuadMesh) -> QuadMesh:
    """The mouth and the brows, thin rolls on the face; face data "tag" is 0 for the mouth, 1 for the brows."""
    cage = Cage()
    for tag, places in ((0, SMILE), (1, LEFT_BROW), (1, RIGHT_BROW)):
        cage.tag = tag
        _roll(cage, body, np.array(places))
    return cage.whole()


def hair(body: QuadMesh) -> QuadMesh:
    """Cards from the crown downwards, each an open strip; vertex data "color" is linear RGB, (n, 3)."""
    random = np.random.default_rng(3)
    cards, shades = [], []
    for n_cards, begin, earlier, lift in LAYERS:
        for k in range(n_cards):
            around = 2 * pi * (k + 0.5 + 0.25 * random.uniform(-1, 1)) / n_cards - pi
            end = _hair_end(around) - earlier + 0.08 * random.uniform(-1, 1)
            cards.append(_card(body, around, (begin, end), lift + 0.005 * random.uniform()))
            shades.append(0.75 + 0.5 * random.uniform())
    grid = np.arange(N_ROWS * N_COLUMNS, dtype=np.int32).reshape(N_ROWS, N_COLUMNS)
    quads = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], axis=-1).reshape(-1, 4)
    starts = grid.size * np.arange(len(cards), dtype=np.int32)
    faces: Ints = (starts[:, None, None] + quads).reshape(-1, 4)
    colors = np.repeat(np.array(shades), grid.size)[:, None] * HAIR_COLOR
    return QuadMesh(np.concatenate(cards), faces, vertex_data={"color": colors})


def _roll(cage: Cage, body: QuadMesh, places: Floats) -> None:
    """A roll through three places on the face, (3, 2), thin at both ends."""
    start, middle, end = places
    t = np.linspace(0.0, 1.0, 13)[:, None]
    angles = (1 - t) ** 2 * start + 2 * t * (1 - t) * (2 * middle - 0.5 * (start + end)) + t**2 * end
    out = facing(angles[:, 0], angles[:, 1])
    centres = HEAD_CENTRE + reach(body, out)[:, None] * out
    across = _unit(np.cross(np.gradient(centres, axis=0), out))
    widths = ROLL * (0.25 + 0.75 * np.sin(pi * t) ** 0.7)
    rings = zip(centres, 0.7 * widths * out, widths * across, strict=True)
    loops = [cage.loop(ellipse(*ring)) for ring in rings]
    for lower, upper in pairwise(loops):
        cage.loft(lower, upper)
    cage.cap(loops[0][::-1], centres[0])
    cage.cap(loops[-1], centres[-1])


def _hair_end(around: float) -> float:
    """Radians from the crown to the end of a card: short over the face, long at the back; 0 is the front."""
    t = np.clip((abs(around) - 0.55) / 1.7, 0.0, 1.0)
    return float(1.32 + 0.75 * t * t * (3.0 - 2.0 * t))


def _card(body: QuadMesh, around: float, span: tuple[float, float], lift: float) -> Floats:
    """Rows from the crown to the tip, each from side to side: (rows * columns, 3)."""
    t, columns = np.linspace(0.0, 1.0, N_ROWS)[:, None], np.linspace(-1.0, 1.0, N_COLUMNS)
    top, left = _unit(np.array(CROWN)), np.array([1.0, 0.0, 0.0])
    turn, down = around + SWIRL * (t - 0.4), span[0] + (span[1] - span[0]) * t
    level = np.cos(turn) * np.cross(left, top) + np.sin(turn) * left
    along = np.cos(down) * top + np.sin(down) * level
    side = np.cross(along, np.cos(down) * level - np.sin(down) * top)
    # Narrow at the crown, pointed at the tip.
    width = CARD_WIDTH * (0.35 + 0.65 * np.sin(0.62 * pi * np.minimum(t / 0.75, 1.0))) * np.sqrt(1.0 - 0.99 * t**4)
    directions = _unit(along[:, None] + (columns * width)[..., None] * side[:, None]).reshape(-1, 3)
    away = (lift + TIP_LIFT * t**2 + RIDGE * (1.0 - columns**2)).ravel()
    return np.asarray(HEAD_CENTRE + (reach(body, directions) + away)[:, None] * directions)


def _unit(vectors: NDArray[np.floating[Any]]) -> Floats:
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))
