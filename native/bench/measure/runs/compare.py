# SPDX-License-Identifier: GPL-3.0-or-later
"""All models, ours and other libraries', on the same tasks: shape, agreement at doubled detail, cost.

    python -m measure.runs.compare OUT.json [--parts PART...] [--tasks NAME...] [--models NAME...]

What is measured takes the place of what the file holds of the same part, task and model. A model that does not do
something has a row {"not_run": why}. Deformed meshes for the pictures go to the folder of the file's name beside it.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ..base import machine
from ..base.contender import write_posed
from ..base.installed import ROOT
from ..base.progress import say
from ..base.workers import NotRun
from ..inputs.compared import Compared, file_part, tasks
from ..inputs.mesh import Floats
from ..inputs.poses import finer
from ..metrics.shape import largest_distance
from .contenders import Entry, Process, Reached, entries, library_of
from .dirty import measure_dirty
from .posed import posed_task
from .quality import file_name, save
from .rows import shape_row
from .same_models import measure_same_models
from .sizes import measure_sizes

PARTS = ("tasks", "sizes", "dirty", "same_models")
TASK, FINER = "task.npz", "finer.npz"
TIMEOUT_S = 30.0  # of a task
FINER_TIMEOUT_S = 20.0  # of the same with four times as many triangles
FINER_TRIANGLES = 4
TOO_LONG = f"would take longer than {FINER_TIMEOUT_S:g} s"


def measure_task(
    task: Compared, models: Sequence[Entry], known: dict[str, Any], pictures: Path, folder: Path
) -> dict[str, Any]:
    """What is said of a task, with a row for each model and those known of other models."""
    pose, name = task.pose, file_name(task.pose)
    write_posed(folder / TASK, posed_task(pose, task.bones))
    write_posed(folder / FINER, posed_task(finer(pose), task.bones))
    rows = dict(known.get("rows", {}))
    for model in models:
        picture = pictures / f"{name}-{file_part(model.name)}.npz"
        picture.unlink(missing_ok=True)
        try:
            rows[model.name], positions = measure_model(task, model, folder)
            save(picture, pose, positions)
        except NotRun as reason:
            rows[model.name] = {"not_run": str(reason)}
        say(f"{name}, {model.name}", rows[model.name])
    return {"mesh": pose.mesh.name, "pose": pose.name, "n_vertices": len(pose.mesh.positions), "rows": rows}


def measure_model(task: Compared, model: Entry, folder: Path) -> tuple[dict[str, Any], Floats]:
    """The row of a model, and where the task ended."""
    with Process(model, folder, TIMEOUT_S) as process:
        reached = process.run(folder / TASK)
        density = density_gap(process, folder / FINER, reached) if may_be_finer(reached) else finer_not_run(TOO_LONG)
    return shape_row(task, reached.positions) | density | reached.costs(), reached.positions


def may_be_finer(reached: Reached) -> bool:
    """Whether as long for each triangle is not too long for a mesh with four times as many: no model gets quicker."""
    task_s: float = reached.said["set_up_s"] + sum(reached.said["step_s"])
    return FINER_TRIANGLES * task_s <= FINER_TIMEOUT_S


def finer_not_run(reason: str) -> dict[str, Any]:
    return {"density": None, "density_not_run": reason}


def density_gap(process: Process, finer_task: Path, reached: Reached) -> dict[str, Any]:
    """How far a vertex is at most from where it is on the mesh whose triangles are cut in four; None if that fails."""
    try:
        finer_positions = process.run(finer_task, FINER_TIMEOUT_S).positions
    except NotRun as reason:
        return finer_not_run(str(reason))
    return {"density": largest_distance(finer_positions[: len(reached.positions)], reached.positions)}


def chosen(names: Sequence[str]) -> list[Compared]:
    """The tasks of these names, all where there are none; raises ValueError for a name that no task has."""
    found = {file_name(task.pose): task for task in tasks()}
    unknown = [name for name in names if name not in found]
    if unknown:
        raise ValueError(f"no task is named {', '.join(unknown)}. The names are {', '.join(found)}")
    return [found[name] for name in names or found]


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.runs.compare", description="All models on the same tasks.")
    parser.add_argument("out", type=Path, help="the JSON file to write")
    parser.add_argument("--parts", nargs="+", choices=PARTS, help="all by default; with --tasks the tasks alone")
    parser.add_argument("--tasks", nargs="+", default=(), help="names of files, as bar_twist_by_135; all by default")
    parser.add_argument("--models", nargs="+", default=(), help='names, as "solid, Keep Volume"; all by default')
    args = parser.parse_args()
    try:
        chosen_tasks, models = chosen(args.tasks), list(entries(args.models))
    except ValueError as error:
        parser.error(str(error))

    pictures = args.out.with_suffix("")
    pictures.mkdir(parents=True, exist_ok=True)
    results: dict[str, Any] = {"tasks": {}, "sizes": [], "dirty": {}, "inputs": {}}
    if args.out.exists():
        results |= json.loads(args.out.read_text())
    results["machine"] = machine.description()
    results["inputs"] |= {entry.name: entry.given for entry in models if entry.given}

    def write() -> None:
        results["versions"] = versions(results["tasks"])
        args.out.write_text(json.dumps(results, indent=1))

    parts = args.parts or (PARTS[:1] if args.tasks else PARTS)
    with tempfile.TemporaryDirectory(dir=ROOT / "build") as temporary:
        folder = Path(temporary)
        if "tasks" in parts:
            for task in chosen_tasks:
                known = results["tasks"].get(file_name(task.pose), {})
                results["tasks"][file_name(task.pose)] = measure_task(task, models, known, pictures, folder)
                write()
        if "sizes" in parts:
            results["sizes"] = measure_sizes(models, folder, results["sizes"])
            write()
        if "dirty" in parts:
            results["dirty"] = measure_dirty(models, folder, results["dirty"])
            write()
        if "same_models" in parts:
            results["same_models"] = measure_same_models(models, folder)
            write()


def versions(found: dict[str, Any]) -> dict[str, str]:
    """Of each library, as the rows of the tasks have it."""
    rows = [item for entry in found.values() for item in entry["rows"].items()]
    return {library_of(model) or "arap_native": row["version"] for model, row in rows if "version" in row}


if __name__ == "__main__":
    main()
