# SPDX-License-Identifier: GPL-3.0-or-later
"""What the fakes of the scenes that follow handles share."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from arap_deform.core.session_data import Readout


def readout(stop_reason: str = "max_iterations", iterations: int = 4) -> Readout:
    return Readout(
        vertices=8, free_vertices=4, last_ms=1.0, iterations=iterations, energy=0.0, energy_before=0.0, step=0.0,
        stop_reason=stop_reason, parts_at_rest=0, loose_vertices=0, bind_ms=0.0, factor_ms=0.0,
    )  # fmt: skip


@dataclass
class FakeBind:
    """Makes its scene fit once it is adopted."""

    scene: Any
    fraction: float = 0.5
    is_done: bool = False
    is_dropped: bool = False
    has_started: bool = False
    error: Exception | None = None

    def start(self) -> None:
        self.has_started = True

    def drop(self) -> None:
        self.is_dropped = True

    def adopt(self) -> None:
        if self.error is not None:
            raise self.error
        self.scene.is_fit = True
