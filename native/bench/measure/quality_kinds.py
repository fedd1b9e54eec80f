# SPDX-License-Identifier: GPL-3.0-or-later
"""How poses of meshes of special kinds come out, and how far from what is known of them."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from .kinds import Kind
from .meshes import Floats, Ints
from .poses import Pose
from .posing import ModelName, Posing, options_of
from .shape import Surface, largest_distance


def measure_kind(kind: Kind, model: ModelName, budget_s: float) -> tuple[dict[str, Any], Floats]:
    """The row of one model, and the deformed positions. Faces are those of the sound mesh, where one is known."""
    pose = kind.pose
    posed = _posed(pose, model, budget_s)
    seen = kind.sound or pose
    n = len(seen.mesh.positions)
    change = Surface(seen.mesh).change(posed[:n], seen.measured())
    row: dict[str, Any] = {"n_vertices": len(pose.mesh.positions), **change._asdict()}
    known = _known(kind, model, budget_s)
    if known is not None:
        vertices, places = known
        row["off"] = largest_distance(posed[vertices], places)
    print(f"{pose.name}, {model}: {row}", file=sys.stderr, flush=True)
    return row, posed


def _known(kind: Kind, model: ModelName, budget_s: float) -> tuple[Ints, Floats] | None:
    if kind.sound is None:
        return kind.known
    n = len(kind.sound.mesh.positions)
    return np.arange(n, dtype=np.int32), _posed(kind.sound, model, budget_s)


def _posed(pose: Pose, model: ModelName, budget_s: float) -> Floats:
    return Posing(pose, options_of(model)).pose(pose.steps, budget_s).positions
