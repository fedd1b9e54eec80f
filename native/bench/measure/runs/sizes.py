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
GROWTH = 4.5  # of the time from a size to the next, at least; the vertices are nine times as many
LIFT = 0.1  # of the ears, a share of the diagonal
TIMEOUT_S = 90.0


def lifted(size: int) -> Pose:
    """The creature's paws held, its ears lifted at once."""
    mesh = triangulated(creature(size))
    held, moved = ends(mesh, 2)
    return Pose("ears lifted", mesh, held, moved, moved_by(LIFT * Z), View((1, 0, 0), (0, 0, 0), 1), steps=1)


def measure_sizes(models: Sequence[Entry], folder: Path, known: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """A row for each size and model, and those known of other models; what cannot succeed at a size is not tried."""
    names = [entry.name for entry in models]
    rows = [row for row in known if row["model"] not in names]
    hopeless: dict[str, str] = {}
    for size in SIZES:
        pose = lifted(size)
        write_posed(folder / "task.npz", posed_task(pose))
        for entry in models:
            reason = hopeless.get(entry.name)
            found = {"not_run": reason} if reason else size_row(entry, folder)
            row = {"model": entry.name, "n_vertices": len(pose.mesh.positions), **found}
            if not reason and (told := why_hopeless_if_larger(row)):
                hopeless[entry.name] = told
            rows.append(row)
            say("size", row)
    return rows


def why_hopeless_if_larger(row: dict[str, Any]) -> str | None:
    """Why the next size cannot succeed if this row is of the one before, as far as that is known."""
    at = f"at {row['n_vertices']} vertices"
    if "not_run" in row:
        return f"{at}: {row['not_run']}"
    took_s: float = row["set_up_s"] + row["frame_s"]
    if GROWTH * took_s <= TIMEOUT_S:
        return None
    return f"would take longer than {TIMEOUT_S:g} s: {at} it takes {took_s:.0f} s"


def size_row(entry: Entry, folder: Path) -> dict[str, Any]:
    try:
        with Process(entry, folder, TIMEOUT_S) as process:
            return process.run(folder / "task.npz").costs()
    except NotRun as reason:
        return {"not_run": str(reason)}
