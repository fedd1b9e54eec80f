# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles, matrices, solver: what a handle's matrix means for vertices. No bpy."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

Progress = Callable[[float], "bool | None"]


class Cancelled(RuntimeError):
    """``progress`` stopped the work; everything is as it was before the call."""


@dataclass(frozen=True)
class Readout:
    """What the last solve did. Energies in the square of world units, times in milliseconds."""

    vertices: int
    free_vertices: int
    last_ms: float
    iterations: int
    energy: float
    energy_before: float
    step: float
    stop_reason: str
    parts_at_rest: int
    loose_vertices: int
    bind_ms: float
    factor_ms: float


class Session:
    """The live session of one mesh."""
