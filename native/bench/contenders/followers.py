# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh that another one carries along: WrapDeformation, and Blender's Surface Deform; see measure.runs.followers.

    python -m contenders.followers

Reads a JSON object a line, {"model": name, "task": path, "out": path}, and answers with a line of JSON:

    version      of the library
    bind_s
    frame_s      of each step; of Blender that of the whole scene

or {"not_run": reason}. The task is what measure.base.carried.write_carried wrote; the result goes to ``out``, an .npz
with positions (k, 3) of the follower at the last step.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import arap_native
import bpy
import numpy as np
from measure.base.carried import Carried, read_carried
from measure.base.contender import Floats
from measure.base.workers import NotRun

from . import scene
from .worker import serve

Carry = Callable[[Floats], Floats]


def wrap(task: Carried, *, stay_outside: bool = True) -> Carry:
    bound = arap_native.WrapDeformation(
        task.follower,
        task.body,
        task.body_corners,
        task.body_sizes,
        options=arap_native.WrapOptions(stay_outside=stay_outside),
    )
    out = np.empty(task.follower.shape, dtype=np.float32)
    return lambda shape: bound.deform(shape, out=out)


def surface_deform(task: Carried) -> Carry:
    scene.clear()
    body = scene.new_mesh("Body", task.body, task.body_corners, task.body_sizes)
    follower = scene.new_mesh("Follower", task.follower, task.follower_corners, task.follower_sizes)
    modifier = follower.modifiers.new("Surface Deform", "SURFACE_DEFORM")
    modifier.target = body
    scene.bind(follower, modifier, bpy.ops.object.surfacedeform_bind, "is_bound")

    def carry(shape: Floats) -> Floats:
        scene.move_vertices(body, shape)
        return scene.evaluated(follower)

    return carry


MODELS: dict[str, tuple[str, Callable[[Carried], Carry]]] = {
    "ours": (arap_native.__version__, wrap),
    "ours, free to come inside": (arap_native.__version__, lambda task: wrap(task, stay_outside=False)),
    "Blender: Surface Deform": (bpy.app.version_string, surface_deform),
}


def run(command: dict[str, Any]) -> dict[str, Any]:
    version, make = MODELS[command["model"]]
    task = read_carried(Path(command["task"]))
    start = time.perf_counter()
    carry = make(task)
    bind_s = time.perf_counter() - start
    frame_s = []
    for shape in task.shapes:
        start = time.perf_counter()
        positions = carry(shape)
        frame_s.append(time.perf_counter() - start)
    if positions.shape != task.follower.shape or not np.isfinite(positions).all():
        raise NotRun("gives positions that are not finite, or not those of all vertices")
    np.savez(command["out"], positions=positions)
    return {"version": version, "bind_s": bind_s, "frame_s": frame_s}


if __name__ == "__main__":
    serve(run)
