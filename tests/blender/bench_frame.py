# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame of posing costs in Blender, end to end: the sample creature at several sizes, handles that are dragged.

    blender -b --factory-startup --python tests/blender/bench_frame.py -- ZIP [OUT.json [N_VERTICES...]]
    python tests/blender/bench_frame.py -- ZIP [OUT.json [N_VERTICES...]]           (a Python with bpy)

A frame is what follows a move of the mouse: Blender evaluates the handle, the add-on reads the handles, maps them to
targets, solves so many iterations and writes the key, Blender evaluates the mesh. The steps are timed within whole
frames, best and median over several drags; then the same drags again as the posing act does them by itself, with its
limit of time.
"""

from __future__ import annotations

import gc
import importlib
import json
import os
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from bench_in_blender import in_blender
from frame_times import DRAGS, PINS, Milliseconds, Stopwatch, creature_object, summary

SIZES = (10_000, 100_000, 1_000_000)
LARGE = 500_000  # vertices from which the goal is one iteration a frame, else two
FRAMES_OUT = 15  # of a drag from rest to its end; then one there and as many back
WARM_UP = 5  # frames before anything counts


class Drags:
    """Moves one handle after the other there and back, a step a frame. Each frame moves one."""

    def __init__(self, obj) -> None:
        self._handles = [(handle.target, DRAGS[handle.name]) for handle in obj.arap.handles]
        self._rest = [(target.location.copy(), target.rotation_euler.copy()) for target, _ in self._handles]
        self._frame = 0

    def __len__(self) -> int:
        return (2 * FRAMES_OUT + 1) * len(self._handles)

    def move(self) -> None:
        """The next place of the mouse."""
        self._frame += 1
        drag, step = divmod(self._frame, 2 * FRAMES_OUT + 1)
        (target, (shift, turn)), (location, rotation) = (
            x[drag % len(self._handles)] for x in (self._handles, self._rest)
        )
        part = 1.0 - abs(step - FRAMES_OUT) / (FRAMES_OUT + 1)
        target.location = [a + part * b for a, b in zip(location, shift, strict=True)]
        target.rotation_euler.z = rotation.z + part * turn


def watched_frames(package: str, obj, iterations: int) -> Milliseconds:
    """Frames of so many iterations, each step timed."""
    import bpy

    update, watch = importlib.import_module(f"{package}.engine.update"), Stopwatch()
    obj.arap.iterations_per_update = iterations
    start = time.perf_counter()
    session = update.prepare_session(obj)
    bind = 1e3 * (time.perf_counter() - start)
    watch.watch_session(package, session)
    outside = ("Blender evaluates the handle", "Blender evaluates the mesh")

    def frame() -> None:
        drags.move()
        with watch.frame(outside=outside, rest="checks, the rest", total="whole frame"):
            with watch.step(outside[0]):
                bpy.context.view_layer.update()
            update.update_pose(obj)
            with watch.step(outside[1]):
                bpy.context.view_layer.update()

    drags = Drags(obj)
    frame()
    first = {"bind": [bind], "bind and first frame": [bind + watch.rows["whole frame"][0]]}
    repeat(frame, WARM_UP)
    watch.rows.clear()
    repeat(frame, len(drags))
    importlib.import_module(f"{package}.core.sessions").drop(obj.session_uid)
    solve = f"solve, {plural(iterations, 'iteration')}"
    return first | {solve if name == "solve" else name: times for name, times in watch.rows.items()}


def act_frames(package: str, obj) -> Milliseconds:
    """Frames as the posing act does them: within its limit of time."""
    import bpy

    update = importlib.import_module(f"{package}.engine.update")
    pose = importlib.import_module(f"{package}.pose.scene")
    interaction = importlib.import_module(f"{package}.engine.interaction")
    obj.arap.property_unset("iterations_per_update")
    update.prepare_session(obj)
    scene = pose.BlenderPoseScene(obj)
    act = interaction.Interaction(scene)
    act.begin()
    rows: Milliseconds = defaultdict(list)

    def frame() -> None:
        drags.move()
        start = time.perf_counter()
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        with scene.evaluated(depsgraph, None):
            act.scene_changed()
        bpy.context.view_layer.update()
        rows["whole frame, by itself"].append(1e3 * (time.perf_counter() - start))
        if act.end is not None:
            raise RuntimeError(f"the posing act has ended: {act.end.message}")
        rows["its iterations"].append(float(act.stats.iterations))

    drags = Drags(obj)
    repeat(frame, WARM_UP)
    rows.clear()
    repeat(frame, len(drags))
    importlib.import_module(f"{package}.core.sessions").drop(obj.session_uid)
    return rows


def repeat(act: Callable[[], object], n: int) -> None:
    for _ in range(n):
        act()


def plural(n: int, noun: str) -> str:
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def bench(package: str, n_vertices: int) -> dict[str, object]:
    """One Blender, one size."""
    import bpy

    api = importlib.import_module(f"{package}.api")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    obj, groups = creature_object(n_vertices)
    for name in PINS:
        api.add_pin(obj, groups[name], name=name)
    for name in DRAGS:
        api.add_handle(obj, groups[name], name=name)
    bpy.context.view_layer.update()
    n = len(obj.data.vertices)
    iterations = 1 if n > LARGE else 2
    load = os.getloadavg()[0]
    rows = dict(watched_frames(package, obj, iterations))
    rows.update(act_frames(package, obj))
    result = {
        "blender": bpy.app.version_string,
        "vertices": n,
        "handles": len(DRAGS),
        "iterations": iterations,
        "frames": len(rows["whole frame"]),
        "load": round(load, 1),
        "ms": summary(rows),
    }
    bpy.data.objects.remove(obj)
    bpy.data.orphans_purge()
    gc.collect()
    return result


def show(result: dict) -> None:
    print(
        f"\nBlender {result['blender']}, {result['vertices']} vertices, {result['handles']} handles; ms, "
        f"{result['frames']} frames, load {result['load']}"
    )
    print(f"{'':32}{'best':>9}{'median':>9}")
    for name, row in result["ms"].items():
        print(f"{name:32}{row['best']:9.3f}{row['median']:9.3f}")
    sys.stdout.flush()


def main(package: str, more: list[str]) -> None:
    results = []
    for size in map(int, more[1:] or SIZES):
        results.append(bench(package, size))
        show(results[-1])
    if more:
        Path(more[0]).write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    in_blender(main)
