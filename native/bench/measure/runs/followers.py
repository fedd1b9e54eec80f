# SPDX-License-Identifier: GPL-3.0-or-later
"""What is worn goes along: WrapDeformation beside Blender's Surface Deform, in the same poses of the same bodies.

    python -m measure.runs.followers OUT.json [--parts PART...]

What is measured takes the place of what the file holds of the same part. Dressed bodies for the pictures go to the
folder of the file's name beside it.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import Any, final

import numpy as np
import zoo

from ..base.carried import Carried, write_carried
from ..base.installed import blender_python
from ..base.parts import measure_parts
from ..base.progress import say
from ..base.workers import Ended, NotRun, Worker
from ..inputs.followers import Worn, bent, shell, worn
from ..inputs.mesh import Floats, Mesh
from ..inputs.poses import Pose
from ..metrics.beside import signed_distances
from .contenders import START_S, environment
from .limb_models import LimbModel, bind, pose_vertices
from .quality import save

PARTS = ("worn", "dirty", "cost")
MODELS = ("ours", "ours, free to come inside", "Blender: Surface Deform")
BODY_MODELS: tuple[LimbModel, ...] = ("surface", "solid")
N_DIRTY_VERTICES = 400
N_COST_VERTICES = 100_000
COST_FRAMES = 12
DIRTY_TIMEOUT_S, TIMEOUT_S = 20.0, 120.0


@final
class Carrier:
    """The process that carries followers; another one where it has ended."""

    def __init__(self, folder: Path) -> None:
        self._out, self._task = folder / "out.npz", folder / "task.npz"
        self._command = (str(blender_python()), "-m", "contenders.followers")
        self._worker: Worker | None = None

    def __enter__(self) -> Carrier:
        return self

    def __exit__(self, *_: object) -> None:
        self._end()

    def carry(self, model: str, task: Carried, timeout_s: float = TIMEOUT_S) -> tuple[Floats, dict[str, Any]]:
        """The follower at the last step, (k, 3), and what the worker said.

        Raises:
            NotRun: the model does not bind it, fails, or ends the process.
        """
        write_carried(self._task, task)
        if self._worker is None:
            self._worker = Worker(self._command, environment(), START_S)
        command = {"model": model, "task": str(self._task), "out": str(self._out)}
        try:
            said = self._worker.ask(json.dumps(command), timeout_s + START_S, what="the task")
        except Ended:
            self._end()
            raise
        if "not_run" in said:
            raise NotRun(said["not_run"])
        with np.load(self._out) as data:
            return data["positions"], said

    def _end(self) -> None:
        if self._worker is not None:
            self._worker.__exit__(None, None, None)
            self._worker = None


def measure_worn(carrier: Carrier, pictures: Path) -> list[dict[str, Any]]:
    """A row for each follower, model of the body, and model of the follower."""
    rows = []
    for item in worn():
        for body_model in BODY_MODELS:
            body = posed_body(item.pose, body_model)
            for model in MODELS:
                about = {"follower": item.name, "pose": item.pose.name, "body": body_model, "model": model}
                try:
                    now, _ = carrier.carry(model, task_of(item, body))
                    name = part_name(item, body_model, model)
                    rows.append(about | distances(item, body, now) | {"picture": name})
                    save_dressed(pictures / f"{name}.npz", item, body, now)
                except NotRun as reason:
                    rows.append(about | {"not_run": str(reason)})
                say(f"{item.name}, {body_model}, {model}", rows[-1])
    return rows


def posed_body(pose: Pose, model: LimbModel) -> Floats:
    return pose_vertices(pose, bind(pose.mesh, model, 0.0)).positions


def task_of(item: Worn, body: Floats) -> Carried:
    mesh, n = item.pose.mesh, len(item.triangles)
    sizes = np.full(n, 3, dtype=np.int32)
    of_body = mesh.positions, mesh.corner_vertices, mesh.face_sizes
    return Carried(*of_body, item.follower, item.triangles.ravel(), sizes, body[None])


def distances(item: Worn, body: Floats, now: Floats) -> dict[str, Any]:
    """The share of its vertices inside the body, how deep, and the change of the distance from it, in gaps."""
    triangles = item.pose.mesh.triangles
    before = signed_distances(item.follower, item.pose.mesh.positions, triangles)
    after = signed_distances(now, body, triangles)
    return {
        "inside": float(np.mean(after < 0)),
        "deepest": float(max(0.0, -after.min()) / item.gap),
        "offset_rms": float(np.sqrt(np.mean(np.square(after - before))) / item.gap),
    }


def part_name(item: Worn, body_model: str, model: str) -> str:
    return "-".join("".join(c if c.isalnum() else "_" for c in part) for part in (item.name, body_model, model))


def save_dressed(path: Path, item: Worn, body: Floats, now: Floats) -> None:
    """The body and the follower as one mesh; grey, as what is held is, is the follower."""
    mesh = item.pose.mesh
    worn_part = len(mesh.positions) + np.arange(len(item.follower), dtype=np.int32)
    both = Mesh(
        mesh.name,
        np.concatenate([mesh.positions, item.follower]),
        np.concatenate([mesh.corner_vertices, item.triangles.ravel() + len(mesh.positions)]).astype(np.int32),
        np.concatenate([mesh.face_sizes, np.full(len(item.triangles), 3)]).astype(np.int32),
    )
    dressed = item.pose._replace(mesh=both, held=worn_part, moved=worn_part[:0])
    save(path, dressed, np.concatenate([body, now]))


def measure_dirty(carrier: Carrier) -> dict[str, Any]:
    """For each model the number of dirty bodies and of dirty followers, how many it carried, and why not the others."""
    found: dict[str, Any] = {}
    tasks = dict(dirty_tasks())
    for model in (MODELS[0], MODELS[-1]):
        failed = {}
        for name, task in tasks.items():
            try:
                carrier.carry(model, task, DIRTY_TIMEOUT_S)
            except NotRun as reason:
                failed[name] = str(reason)
        found[model] = {"n_tasks": len(tasks), "n_bound": len(tasks) - len(failed), "failed": failed}
        say(f"dirty, {model}", found[model])
    return found


def dirty_tasks() -> Iterator[tuple[str, Carried]]:
    """Each kind of dirty mesh as the body of a clean rod that is as large, and as the follower of one."""
    clean, _ = shell(N_DIRTY_VERTICES)
    for kind, make in zoo.KINDS.items():
        mesh = make(N_DIRTY_VERTICES, np.random.default_rng(1))
        size = float(np.linalg.norm(np.ptp(mesh.positions, axis=0))) or 1.0
        rod = clean.positions * size + mesh.positions.mean(axis=0)
        dirty = mesh.positions, mesh.corners, mesh.sizes
        tidy = rod, clean.corner_vertices, clean.face_sizes
        yield f"body: {kind}", Carried(*dirty, *tidy, shapes=1.1 * mesh.positions[None])
        yield f"follower: {kind}", Carried(*tidy, *dirty, shapes=1.1 * rod[None])


def measure_cost(carrier: Carrier) -> list[dict[str, Any]]:
    """Seconds to bind, and of a frame, with as many vertices of the body as of the follower."""
    body, follower = shell(N_COST_VERTICES)
    arrays = body.corner_vertices, body.face_sizes
    shapes = np.stack([bent(body.positions, np.radians(90) * (k + 1) / COST_FRAMES) for k in range(COST_FRAMES)])
    rows = []
    for model in MODELS:
        about = {"model": model, "n_vertices": len(follower)}
        try:
            _, said = carrier.carry(model, Carried(body.positions, *arrays, follower, *arrays, shapes))
            rows.append(about | {"bind_s": said["bind_s"], "frame_s": median(said["frame_s"])})
        except NotRun as reason:
            rows.append(about | {"not_run": str(reason)})
        say(f"cost, {model}", rows[-1])
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(prog="measure.runs.followers", description="What is worn goes along.")
    parser.add_argument("out", type=Path, help="the JSON file to write")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    args = parser.parse_args()

    pictures = args.out.with_suffix("")
    pictures.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, Carrier(Path(folder)) as carrier:
        measures: dict[str, Callable[[], Any]] = {
            "worn": lambda: measure_worn(carrier, pictures),
            "dirty": lambda: measure_dirty(carrier),
            "cost": lambda: measure_cost(carrier),
        }
        measure_parts(args.out, args.parts, measures)


if __name__ == "__main__":
    main()
