# SPDX-License-Identifier: GPL-3.0-or-later
"""Models that other libraries have, too: whether both end at the same place, and how long each takes, in one run."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

from ..base.contender import write_posed
from ..base.progress import say
from ..base.workers import NotRun, Worker
from ..inputs.compared import tasks
from .contenders import Entry, environment
from .posed import posed_task
from .quality import file_name

TIMEOUT_S = 300.0
PLANE, ROD = "plane_pulled_up", "rod_bend_by_120"
KNEE, MOVED_ONLY = "creature_paw_knee_of_90", "creature_head_moved_only"


class Pair(NamedTuple):
    """A model of ours, with its module of ``contenders``, and the same one of another library.

    Attributes:
        tasks: by their files' names. Poisson editing is harmonic interpolation only where nothing is turned.
    """

    module: str
    ours: str
    theirs: str
    tasks: tuple[str, ...]


PAIRS = (
    Pair("ours", "Poisson, harmonic", "libigl: harmonic", (PLANE, MOVED_ONLY)),
    Pair("ours", "surface, spokes", "libigl: ARAP, spokes", (PLANE, ROD)),
    Pair("ours", "surface, spokes", "CGAL: ARAP, spokes", (PLANE, ROD)),
    Pair("ours", "surface, spokes", "Open3D: ARAP, spokes", (PLANE,)),
    Pair("ours", "surface, spokes and rims", "libigl: ARAP, spokes and rims", (PLANE, ROD)),
    Pair("ours", "surface, spokes and rims", "CGAL: ARAP, spokes and rims", (PLANE, ROD)),
    Pair("ours_on_tetgen", "tetrahedra of TetGen", "libigl: ARAP, tetrahedra", (ROD,)),
    Pair("ours_cages", "cage, harmonic", "Blender: Mesh Deform", (ROD, KNEE)),
)


def measure_same_models(models: Sequence[Entry], folder: Path) -> dict[str, Any]:
    """Rows of the pairs whose other model is among ``models``, and the names of those that ours are not like."""
    posed = {file_name(task.pose): task for task in tasks()}
    entries = {entry.name: entry for entry in models}
    rows: list[dict[str, Any]] = []
    for pair in PAIRS:
        for name in pair.tasks if pair.theirs in entries else ():
            path = folder / f"{name}.npz"
            write_posed(path, posed_task(posed[name].pose, posed[name].bones))
            rows.append({"ours": pair.ours, "theirs": pair.theirs, "task": name} | row_of(pair, entries, path))
            say(f"the same model, {pair.theirs}, {name}", rows[-1])
    paired = {pair.theirs for pair in PAIRS}
    return {"rows": rows, "alone": [name for name in entries if ":" in name and name not in paired]}


def row_of(pair: Pair, entries: dict[str, Entry], task: Path) -> dict[str, Any]:
    """What contenders/same_models.py says, its times as medians: [ours, theirs], and of theirs / ours of each pair."""
    entry = entries[pair.theirs]
    if entry.not_run:
        return {"not_run": entry.not_run}
    python, *_, module = entry.command
    command = {"ours": [pair.module, pair.ours], "theirs": [module, pair.theirs], "task": str(task)}
    try:
        with Worker((python, "-m", "contenders.same_models"), environment(), TIMEOUT_S) as worker:
            said = worker.ask(json.dumps(command), what="both")
    except NotRun as reason:
        return {"not_run": str(reason)}
    for part in ("set_up", "step"):
        times = said.pop(f"{part}_s", None)
        if times is not None:
            said[f"{part}_s"] = [median(column) for column in zip(*times, strict=True)]
            said[f"{part}_ratio"] = median(theirs / ours for ours, theirs in times)
    return said
