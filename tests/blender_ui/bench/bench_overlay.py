# SPDX-License-Identifier: GPL-3.0-or-later
"""What a redraw with the overlay costs at 100,000 vertices: all of it on, with and without a change of the pose.

run.py --blender BLENDER --zip ZIP --screenshots DIR --files "bench/bench_*.py" --size 1280x800 --at-once 1

Writes overlay.json into the folder of the screenshots.
"""

import json
import os
import time
from collections.abc import Callable
from unittest.mock import patch

import bpy
import scenes
from frame_times import Milliseconds, summary
from harness import Steps, Ui
from test_overlay import drawn, redraw, show_all

SIDE = 317
TIMES = 30


def spent_ms(call: Callable[[], object]) -> float:
    start = time.perf_counter()
    call()
    return 1e3 * (time.perf_counter() - start)


def test_overlay_cost(ui: Ui) -> Steps:
    grid = scenes.add_held_grid(ui.api, SIDE)
    grid.arap.handles[0].target.location.z = 0.5
    bpy.context.view_layer.update()
    ui.api.solve(grid)
    ui.select(grid)
    show_all(grid)
    yield from redraw(ui)
    overlay = ui.overlay
    load = os.getloadavg()[0]
    rows: Milliseconds = {}
    for what, call in measured(overlay, grid, drawn(ui)["Grid"]).items():
        with ui.override():
            rows[what] = [spent_ms(call) for _ in range(TIMES)]
    spent = rows["software OpenGL draws it"] = []

    def draw_again() -> None:
        spent.append(spent_ms(overlay._draw_in_space))

    handler = bpy.types.SpaceView3D.draw_handler_add(draw_again, (), "WINDOW", "POST_VIEW")
    for _ in range(TIMES):
        yield from redraw(ui)
    bpy.types.SpaceView3D.draw_handler_remove(handler, "WINDOW")
    about = {"blender": bpy.app.version_string, "vertices": SIDE * SIDE, "load": round(load, 1)}
    result = {**about, "ms": summary(rows)}
    (ui.screenshots / "overlay.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")


def measured(overlay, grid: bpy.types.Object, found) -> dict[str, Callable[[], object]]:
    depsgraph = bpy.context.evaluated_depsgraph_get()

    def after_a_pose() -> None:
        overlay._changes += 1
        found.update(grid, depsgraph)

    def after_an_edit() -> None:
        overlay.data.Surface.read(grid, depsgraph)

    def all_but_drawing() -> None:
        # No mocks: they keep the batches until Blender has quit, and batches freed as late as that crash it.
        with patch.multiple(overlay.Drawn, draw=lambda *_: None):
            overlay._draw_in_space()

    return {
        "a redraw without a change, but for drawing": all_but_drawing,
        "of it looking for changes": lambda: found.update(grid, depsgraph),
        "colors and batches after a pose": after_a_pose,
        "of it strain and colors": lambda: overlay.data.strain_colors(grid, found.surface),
        "faces and edges after an edit": after_an_edit,
    }
