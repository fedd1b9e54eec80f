# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame costs in a window: the sample creature at three sizes, a handle, the surface or a blend being dragged.

run.py --blender BLENDER --zip ZIP --screenshots DIR --files "bench/bench_*.py" --size 1280x800 --at-once 1

Each test writes drag-ACT-SIZE.json into the folder of the screenshots, for each of the vertex counts in
ARAP_BENCH_SIZES (default: 10000 100000 1000000).
"""

import importlib
import json
import math
import os
from collections.abc import Callable, Generator

import bpy
from frame_times import DRAGS, PINS, Milliseconds, Stopwatch, creature_object, summary
from harness import MODULE, Steps, Ui
from main_loop import WARM_UP, MainLoop, move_each_turn
from mathutils import Vector

SIZES = tuple(int(size) for size in os.environ.get("ARAP_BENCH_SIZES", "10000 100000 1000000").split())
LARGE = 500_000  # vertices from which fewer frames will do
PIXELS = 60  # radius of the circle that the mouse goes
TURNS = 40  # of the main loop, once around
GRIP = (0.0, -1.0, 1.0)  # in front of the creature's head
NAME = "Creature"

Act = Callable[[Ui, bpy.types.Object], Generator[None, None, Milliseconds]]


def measure(ui: Ui, act: Act, *, has_handles: bool = True) -> Steps:
    """One size after the other, each in a new file."""
    for size in SIZES:
        creature = begin(ui, size, has_handles=has_handles)
        load = os.getloadavg()[0]
        yield from ui.move_mouse(*ui.pixel(GRIP))
        rows = yield from act(ui, creature)
        yield from ui.until_free()
        result = {
            "blender": bpy.app.version_string,
            "act": act.__name__,
            "vertices": len(creature.data.vertices),
            "load": round(load, 1),
            "frames": n_frames(creature),
            "ms": summary(rows),
        }
        path = ui.screenshots / f"drag-{act.__name__}-{size:07}.json"
        path.write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
        yield from ui.end()
        ui.begin(f"bench_{act.__name__}")


def begin(ui: Ui, size: int, *, has_handles: bool) -> bpy.types.Object:
    """The creature alone, its paws pinned, seen from the front in a view that fills the window."""
    ui.call(bpy.ops.screen.screen_full_area, "EXEC_DEFAULT", True, use_hide_panels=True)
    for obj in list(bpy.data.objects):
        bpy.data.objects.remove(obj)
    creature, groups = creature_object(size)
    for name in PINS:
        ui.api.add_pin(creature, groups[name], name=name)
    for name in DRAGS if has_handles else ():
        ui.api.add_handle(creature, groups[name], name=name)
    ui.select(creature)
    ui.call(bpy.ops.view3d.view_axis, "EXEC_DEFAULT", True, type="FRONT")
    ui.call(bpy.ops.view3d.view_selected, "EXEC_DEFAULT", True)
    return creature


def n_frames(creature: bpy.types.Object) -> int:
    return 12 if len(creature.data.vertices) > LARGE else 60


def circle(start: tuple[int, int]) -> Callable[[int], tuple[int, int]]:
    """A place of the mouse for each turn, round and round through ``start``."""

    def place(turn: int) -> tuple[int, int]:
        angle = 2.0 * math.pi * turn / TURNS
        return start[0] + round(PIXELS * math.sin(angle)), start[1] + round(PIXELS * (math.cos(angle) - 1.0))

    return place


def to_and_fro(start: tuple[int, int], pixels: float) -> Callable[[int], tuple[int, int]]:
    """To the right and back."""

    def place(turn: int) -> tuple[int, int]:
        return start[0] + round(pixels * (0.5 - 0.5 * math.cos(2.0 * math.pi * turn / TURNS))), start[1]

    return place


def pose(ui: Ui, creature: bpy.types.Object) -> Generator[None, None, Milliseconds]:
    """The head's handle is moved by G, within a posing act."""
    ui.select(bpy.data.objects["Head"])
    assert ui.call(bpy.ops.arap.pose) == {"RUNNING_MODAL"}
    yield from ui.until(lambda: NAME in ui.running and ui.running[NAME].stats is not None, "it is bound")
    act = ui.running[NAME]
    loop = MainLoop(ui, lambda: act.stats.iterations)
    loop.watch_act(act, "_guarded")
    loop.watch_evaluation(act._scene)
    yield from ui.key("G")
    yield from loop.move(circle(ui.mouse), n_frames(creature))
    yield from ui.key("ESC")
    yield from ui.key("ESC")
    return loop.rows


def blend(ui: Ui, creature: bpy.types.Object) -> Generator[None, None, Milliseconds]:
    """The factor between rest and a stored pose of all handles."""
    for handle in creature.arap.handles:
        shift, turn = DRAGS[handle.name]
        handle.target.location += Vector(shift)
        handle.target.rotation_euler.z += turn
    bpy.context.view_layer.update()
    ui.api.store_pose(creature, "Moved")
    ui.api.reset_handles(creature)
    bpy.context.view_layer.update()
    yield
    ui.call(bpy.ops.arap.poses_blend, "INVOKE_DEFAULT", True, start="REST", pose="Moved")
    run = ui.running[NAME]
    yield from ui.until(lambda: run.is_ready and run._tracker.stats is not None, "it is bound")
    loop = MainLoop(ui, lambda: run._tracker.stats.iterations)
    loop.watch_step(run, "set_factor", "place handles")
    loop.watch_act(run, "set_factor", "tick")
    loop.watch_evaluation(run._tracker._scene)
    yield from loop.move(to_and_fro(ui.mouse, run._pixels), n_frames(creature))
    yield from ui.key("ESC")
    return loop.rows


def pull(ui: Ui, creature: bpy.types.Object) -> Generator[None, None, Milliseconds]:
    """ARAP Pull drags the head; before that the mouse goes over the surface."""
    assert ui.call(bpy.ops.arap.pull_tool) == {"FINISHED"}
    start = ui.mouse
    pointing = yield from point(ui, n_frames(creature))
    yield from ui.move_mouse(*start)
    ui.event("LEFTMOUSE", "PRESS")
    yield
    for i in range(1, 5):
        yield from ui.move_mouse(start[0] + 5 * i, start[1])
    yield from ui.until(lambda: NAME in ui.running and ui.running[NAME].stats is not None, "it is bound")
    run = ui.pull.runs[0]
    loop = MainLoop(ui, lambda: run.interaction.stats.iterations)
    loop.watch_act(run, "move", "tick", "show_status")
    loop.watch_evaluation(run.scene)
    yield from loop.move(circle(ui.mouse), n_frames(creature))
    yield from ui.key("ESC")
    ui.event("LEFTMOUSE", "RELEASE")
    return {**loop.rows, "pointing": pointing}


def point(ui: Ui, n: int) -> Generator[None, None, list[float]]:
    """What the circle and the patch under the mouse take, for so many places of the mouse."""
    watch, spent = Stopwatch(), []
    draw = importlib.import_module(f"{MODULE}.pull.draw")
    draw_cursor = draw.draw_cursor
    watch.watch(draw, "draw_cursor", "point")
    around = circle(ui.mouse)

    def place(turn: int) -> tuple[int, int]:
        spent.extend(watch.take().values())
        return around(turn)

    yield from move_each_turn(ui, place, lambda: len(spent) >= n)
    draw.draw_cursor = draw_cursor
    return spent[WARM_UP:]


def test_pose(ui: Ui) -> Steps:
    yield from measure(ui, pose)


def test_pull(ui: Ui) -> Steps:
    yield from measure(ui, pull, has_handles=False)


def test_blend(ui: Ui) -> Steps:
    yield from measure(ui, blend)
