# SPDX-License-Identifier: GPL-3.0-or-later
"""One step of every model on the same shape in several sizes: seconds and memory."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..base.contender import write_posed
from ..base.progress import say
from ..base.workers import NotRun
from ..inputs.compared import moved_by
from ..inputs.mesh import creature, triangulated
from ..inputs.poses import Pose, View, Z
from ..inputs.tasks import ends
from .contenders import Entry, Process
from .posed import posed_task

SIZES = (10_000, 100_000, 1_000_000)
LIFT = 0.1  # of the ears, a share of the diagonal
TIMEOUT_S = 90.0


def lifted(size: int) -> Pose:
    """The creature's paws held, its ears lifted at once."""
    mesh = triangulated(creature(size))
    held, moved = ends(mesh, 2)
    return Pose("ears lifted", mesh, held, moved, moved_by(LIFT * Z), View((1, 0, 0), (0, 0, 0), 1), steps=1)


def measure_sizes(models: Sequence[Entry], folder: Path, known: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """A row for each size and model, and those known of other models; what fails at a size is not tried at the next."""
    names = [entry.name for entry in models]
    rows = [row for row in known if row["model"] not in names]
    failed: dict[str, str] = {}
    for size in SIZES:
        pose = lifted(size)
        n_vertices = len(pose.mesh.positions)
        write_posed(folder / "task.npz", posed_task(pose))
        for entry in models:
            row = {"model": entry.name, "n_vertices": n_vertices, **size_row(entry, folder, failed.get(entry.name))}
            if "not_run" in row:
                failed.setdefault(entry.name, f"at {n_vertices} vertices: {row['not_run']}")
            rows.append(row)
            say("size", row)
    return rows


def size_row(entry: Entry, folder: Path, failed: str | None) -> dict[str, Any]:
    if failed is not None:
        return {"not_run": failed}
    try:
        with Process(entry, folder, TIMEOUT_S) as process:
            return process.run(folder / "task.npz").costs()
    except NotRun as reason:
        return {"not_run": str(reason)}
