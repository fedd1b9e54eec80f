# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame of posing costs beside the solver, at 100,000 vertices.

    blender -b --factory-startup --python tests/blender/bench_frame.py -- ZIP [OUT.json [N_VERTICES]]
    python tests/blender/bench_frame.py -- ZIP [OUT.json [N_VERTICES]]           (a Python with bpy)

Measured apart, best and median of many frames, each after a handle has moved: checking that the session still fits,
reading the handles, mapping them to targets, taking the positions over, writing the key with update_tag. Then one
whole update_pose() beside the solver's own time, and Blender's evaluation of the mesh after it.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import run

N_HANDLES = 5
GROUP_SIZE = 400
N_FRAMES = 60
GOAL_MS = 2.0  # on Blender 4.1 and later


def tube(n_vertices: int) -> tuple:
    import numpy as np

    segments = max(8, round((n_vertices / 4) ** 0.5))
    rings = n_vertices // segments
    angle = np.arange(segments) * (2.0 * np.pi / segments)
    height = np.linspace(0.0, 12.0, rings)
    positions = np.empty((rings, segments, 3), dtype=np.float32)
    positions[..., 0], positions[..., 1] = np.cos(angle), np.sin(angle)
    positions[..., 2] = height[:, None]
    i, j = np.meshgrid(np.arange(rings - 1), np.arange(segments), indexing="ij")
    right = (j + 1) % segments
    faces = np.stack([i, i, i + 1, i + 1], -1) * segments + np.stack([j, right, right, j], -1)
    return positions.reshape(-1, 3), faces.reshape(-1, 4).astype(np.int32)


def mesh_object(n_vertices: int):
    import bpy
    import numpy as np

    positions, faces = tube(n_vertices)
    mesh = bpy.data.meshes.new("Tube")
    mesh.vertices.add(len(positions))
    mesh.loops.add(faces.size)
    mesh.polygons.add(len(faces))
    mesh.vertices.foreach_set("co", positions.ravel())
    mesh.loops.foreach_set("vertex_index", faces.ravel())
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 4, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(faces), 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    obj = bpy.data.objects.new("Tube", mesh)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def timed(act: Callable[[], object], prepare: Callable[[], object] = lambda: None) -> tuple[float, float]:
    """Best and median milliseconds of ``act`` alone, each time after ``prepare``."""
    times = []
    for _ in range(N_FRAMES):
        prepare()
        start = time.perf_counter()
        act()
        times.append(1e3 * (time.perf_counter() - start))
    times.sort()
    return times[0], times[len(times) // 2]


def bench(zip_path: Path, n_vertices: int) -> dict[str, object]:
    import importlib

    import bpy

    package = run.install(zip_path)

    def module(name: str):
        return importlib.import_module(f"{package}.{name}")

    api, handle_io, shape_key = module("api"), module("handle_io"), module("shape_key")
    obj = mesh_object(n_vertices)
    n = len(obj.data.vertices)
    api.add_pin(obj, range(GROUP_SIZE), name="Pin")
    for i in range(1, N_HANDLES + 1):
        first = i * (n - GROUP_SIZE) // N_HANDLES
        api.add_handle(obj, range(first, first + GROUP_SIZE), name=f"Handle {i}")
    bpy.context.view_layer.update()
    session = api.prepare_session(obj)
    obj.arap.iterations_per_update = 1
    api.update_pose(obj)
    key = shape_key.find(obj, obj.arap.key_name)
    targets = [handle.target for handle in obj.arap.handles]
    frame = 0

    def move() -> None:
        nonlocal frame
        frame += 1
        for target in targets:
            target.location.x += 0.01 * (-1) ** (frame // 10)
        bpy.context.view_layer.update()

    depsgraph = bpy.context.evaluated_depsgraph_get()
    positions = session._solver.positions
    matrices = handle_io.handle_matrices(obj, depsgraph)

    def read() -> None:
        nonlocal matrices
        matrices = handle_io.handle_matrices(obj, depsgraph)

    def write() -> None:
        shape_key.write(obj, key, session.positions)
        shape_key.show(key)

    beside_solver = []

    def update() -> None:
        start = time.perf_counter()
        done = api.update_pose(obj, depsgraph)
        beside_solver.append(1e3 * (time.perf_counter() - start) - done.last_ms)

    rows = {
        "check the session": timed(lambda: api.check_live(obj), move),
        "read the handles": timed(read, move),
        "map to targets": timed(lambda: session._map.targets(matrices), lambda: (move(), read())),
        "take positions over": timed(lambda: session._take(positions)),
        "write the key": timed(write, move),
    }
    rows["together"] = tuple(sum(row[i] for row in rows.values()) for i in (0, 1))
    rows["update_pose, 1 step"] = timed(update, move)
    rows["update_pose - solver"] = min(beside_solver), sorted(beside_solver)[len(beside_solver) // 2]
    rows["Blender evaluates it"] = timed(bpy.context.view_layer.update, update)
    print(f"\nBlender {bpy.app.version_string}, {n} vertices, {N_HANDLES} handles of {GROUP_SIZE} vertices; ms")
    print(f"{'':24}{'best':>9}{'median':>9}")
    for name, (best, median) in rows.items():
        goal = f"   goal on 4.1+: {GOAL_MS:.0f}" if name == "together" else ""
        print(f"{name:24}{best:9.3f}{median:9.3f}{goal}")
    return {
        "blender": bpy.app.version_string,
        "vertices": n,
        "handles": N_HANDLES,
        "ms": {name: {"best": best, "median": median} for name, (best, median) in rows.items()},
    }


def main() -> None:
    if run.USER_FOLDER not in os.environ:
        run.start_again()
    code = 1
    try:
        arguments = sys.argv[sys.argv.index("--") + 1 :]
        result = bench(Path(arguments[0]).resolve(), int(arguments[2]) if len(arguments) > 2 else 100_000)
        if len(arguments) > 1:
            Path(arguments[1]).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        code = 0
    finally:
        shutil.rmtree(os.environ[run.USER_FOLDER], ignore_errors=True)
        if code:
            sys.excepthook(*sys.exc_info())
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)


if __name__ == "__main__":
    main()
