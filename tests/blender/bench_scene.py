# SPDX-License-Identifier: GPL-3.0-or-later
"""What the add-on costs a scene without any object of its own: its ratio to the scene without the add-on's handlers.

    python tests/blender/bench_scene.py -- ZIP [OUT.json [N_OBJECTS]]           (a Python with bpy)

All objects hang on one empty that moves. Evaluations and changes of frame with and without the handlers alternate.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from bench_in_blender import in_blender
from frame_times import median

N_OBJECTS = 10_000
PAIRS = 15
LISTS = ("depsgraph_update_post", "frame_change_post")


def scene_of(n_objects: int):
    """A scene of so many objects that move; the empty that moves them."""
    import bpy

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    top = bpy.data.objects.new("Top", None)
    bpy.context.scene.collection.objects.link(top)
    for i in range(n_objects - 1):
        child = bpy.data.objects.new(f"Child {i}", None)
        child.parent = top
        bpy.context.scene.collection.objects.link(child)
    top.keyframe_insert("location", frame=1)
    top.location.x = 1.0
    top.keyframe_insert("location", frame=1000)
    bpy.context.view_layer.update()
    return top


def ratio(act: Callable[[int], None], package: str) -> dict[str, float]:
    """Of pairs of runs; their medians in ms."""
    import bpy

    lists = [getattr(bpy.app.handlers, name) for name in LISTS]
    others = [[each for each in functions if not each.__module__.startswith(package)] for functions in lists]
    whole = [functions.copy() for functions in lists]
    ms: dict[bool, list[float]] = {True: [], False: []}
    for k in range(2 * PAIRS + 2):
        with_addon = k % 2 == 0
        for functions, heard in zip(lists, whole if with_addon else others, strict=True):
            functions[:] = heard
        start = time.perf_counter()
        act(k)
        if k >= 2:
            ms[with_addon].append(1e3 * (time.perf_counter() - start))
    pairs = [a / b for a, b in zip(ms[True], ms[False], strict=True)]
    return {"ratio": median(pairs), "with_ms": median(ms[True]), "without_ms": median(ms[False])}


def bench(package: str, n_objects: int) -> dict[str, object]:
    import bpy

    top = scene_of(n_objects)

    def evaluate(k: int) -> None:
        top.location.y = float(k)
        bpy.context.view_layer.update()

    def change_frame(k: int) -> None:
        bpy.context.scene.frame_set(10 + k)

    return {
        "blender": bpy.app.version_string,
        "objects": n_objects,
        "load": round(os.getloadavg()[0], 1),
        "evaluation": ratio(evaluate, package),
        "frame": ratio(change_frame, package),
    }


def main(package: str, more: list[str]) -> None:
    result = bench(package, int(more[1]) if len(more) > 1 else N_OBJECTS)
    print(json.dumps(result, indent=1), flush=True)
    if more:
        Path(more[0]).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    in_blender(main)
