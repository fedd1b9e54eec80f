# SPDX-License-Identifier: GPL-3.0-or-later
"""What a heavy sculpt costs in Blender: twenty meshes of five million vertices together, posed through a stand-in.

    python tests/blender/bench_stand_in.py -- ZIP [OUT.json [N_VERTICES [N_MESHES]]]           (a Python with bpy)

The meshes are balls in a row that overlap; the first is pinned, the last dragged. A frame is what follows a move of the
mouse: the stand-in is solved, all meshes go along, Blender evaluates them.
"""

from __future__ import annotations

import importlib
import json
import os
import resource
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from bench_in_blender import in_blender
from frame_times import NativeProxy, Stopwatch, summary

N_VERTICES, N_MESHES = 5_000_000, 20
FRAMES = 20
WARM_UP = 3
STEP = (0.05, 0.0, 0.1)  # of the drag, in radii of a ball


def ball(name: str, n_vertices: int, place: float):
    """A mesh object, a sphere of radius 1 with bumps at (place, 0, 0)."""
    import bpy
    import numpy as np
    from scenes.blender_scene import quads_mesh

    around = round(n_vertices**0.5)
    u, v = np.meshgrid(np.arange(around), np.arange(around), indexing="xy")
    theta, phi = np.pi * (v + 0.5) / around, 2 * np.pi * u / around
    radius = 1 + 0.01 * np.sin(40 * phi) * np.sin(40 * theta)
    round_ = np.stack([np.cos(theta), np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi)], axis=-1)
    points = (radius[..., None] * round_).reshape(-1, 3)
    here = np.arange(around * (around - 1), dtype=np.int32)
    right = here // around * around + (here + 1) % around
    quads = np.stack([here, right, right + around, here + around], axis=1)
    obj = bpy.data.objects.new(name, quads_mesh(name, points, quads))
    obj.location.x = place
    bpy.context.scene.collection.objects.link(obj)
    return obj


def ends(stand_in, length: float):
    """The vertices of the first ball and of the last."""
    import numpy as np

    places = np.empty(3 * len(stand_in.data.vertices), dtype=np.float32)
    stand_in.data.vertices.foreach_get("co", places)
    x = places.reshape(-1, 3)[:, 0] + stand_in.location.x
    return np.flatnonzero(x < 0.5), np.flatnonzero(x > length - 0.5)


def bench(package: str, n_vertices: int, n_meshes: int) -> dict[str, object]:
    import bpy

    api = importlib.import_module(f"{package}.api")
    update, watch = importlib.import_module(f"{package}.engine.update"), Stopwatch()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    pieces = [ball(f"Ball {k}", n_vertices // n_meshes, 1.5 * k) for k in range(n_meshes)]
    bpy.context.view_layer.update()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.perf_counter()
    stand_in = api.make_stand_in(pieces)
    made = time.perf_counter()
    pinned, moved = ends(stand_in, 1.5 * (n_meshes - 1))
    api.add_pin(stand_in, pinned, name="Pin")
    handle = stand_in.arap.controls[api.add_handle(stand_in, moved, name="Handle")]
    bpy.context.view_layer.update()
    session = update.prepare_session(stand_in)
    handle.target.location.z += 0.01
    bpy.context.view_layer.update()
    update.update_pose(stand_in)  # what goes along is bound now
    first = {"stand-in": [1e3 * (made - start)], "bind": [1e3 * (time.perf_counter() - made)]}
    bpy.context.view_layer.update()
    session._model = NativeProxy(session._model)
    watch.watch(session._model, "solve", "solve")
    watch.watch(importlib.import_module(f"{package}.attach.sync_handlers"), "write", "all go along, and are written")
    for frame in range(WARM_UP + FRAMES):
        if frame == WARM_UP:
            watch.rows.clear()
        handle.target.location.x += STEP[0]
        handle.target.location.z += STEP[2]
        with watch.frame(outside=("Blender evaluates",), rest="the stand-in is written, the rest", total="whole frame"):
            update.update_pose(stand_in)
            with watch.step("Blender evaluates"):
                bpy.context.view_layer.update()
    return {
        "blender": bpy.app.version_string,
        "vertices": sum(len(piece.data.vertices) for piece in pieces),
        "meshes": n_meshes,
        "stand_in": len(stand_in.data.vertices),
        "peak_mb": (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024,
        "load": round(os.getloadavg()[0], 1),
        "ms": summary(first | watch.rows),
    }


def main(package: str, more: list[str]) -> None:
    sizes = [int(word) for word in more[1:]] or [N_VERTICES, N_MESHES]
    result = bench(package, *sizes)
    print(json.dumps(result, indent=1), flush=True)
    if more:
        Path(more[0]).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    in_blender(main)
