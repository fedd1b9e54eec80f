# SPDX-License-Identifier: GPL-3.0-or-later
"""A monkey at the window: random but legal input, acts one after the other whatever the one before has left behind.

ARAP_MONKEY_ACTS says how many at least (100), ARAP_MONKEY_MINUTES how long at least (0), ARAP_MONKEY_SEED
which (1). Each act is printed before it is done, so a failure tells the way to it. After
each: the meshes are where finite numbers can be drawn, rest shapes are untouched, nothing was printed that looks like
an exception (the runner's part).
"""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from itertools import count
from pathlib import Path
from random import Random

import bpy
import numpy as np
import scenes
import test_pull
from harness import Steps, Ui
from test_follow import add_second_bar

N_ACTS = int(os.environ.get("ARAP_MONKEY_ACTS", "100"))
MINUTES = float(os.environ.get("ARAP_MONKEY_MINUTES", "0"))
SEED = int(os.environ.get("ARAP_MONKEY_SEED", "1"))
FAR = 1e4  # no mesh has a reason to get there: each drag moves a handle by a few units
OPERATORS = (
    "solve", "bake_pose", "reset", "apply_pose_as_rest", "pin_add", "handle_add",
    "control_remove", "pull_tool", "pull_make_real", "pull_release", "poses_store", "poses_apply", "poses_mirror",
    "poses_delete", "poses_to_keys", "stiffness_add", "stiffness_remove", "group_soften", "group_paint",
    "select_free_parts", "cage_make",
)  # fmt: skip


class Monkey:
    def __init__(self, ui: Ui) -> None:
        self.ui = ui
        self.random = Random(SEED)
        self.file = Path(tempfile.mkdtemp()) / "monkey.blend"
        self.rests: set[bytes] = set()
        self.edited: set[str] = set()
        self.acts: list[Callable[[], Steps]] = [
            *[self.drag_object] * 4, *[self.drag_surface] * 4, *[self.undo] * 3, *[self.redo] * 2, *[self.select] * 2,
            self.begin_pose, self.enter, self.escape, self.click_surface, self.call_operator, self.switch_follow,
            self.change_frame, self.play, self.change_mode, self.change_setting, self.rename, self.rename_group,
            self.duplicate, self.delete, self.hide, self.save_and_open, self.change_scene, self.press_key,
        ]  # fmt: skip

    def build(self) -> None:
        """Two bars with pins and handles, and the keys of an animation."""
        self.remember_rests()  # undo leads back to the cube
        scenes.add_bar_with_handle(self.ui.api)
        add_second_bar(self.ui)
        for name, reach in (("Top", 1.0), ("Other", -1.0)):
            handle = bpy.data.objects[name]
            for frame, x in ((1, 0.0), (10, reach)):
                handle.location.x += x
                handle.keyframe_insert("location", frame=frame)
        bpy.context.scene.frame_end = 10
        self.remember_rests()
        bpy.ops.ed.undo_push(message="the monkey's scene")

    # What it looks at.
    def meshes(self) -> list[bpy.types.Object]:
        return [obj for obj in bpy.context.view_layer.objects if obj is not None and obj.type == "MESH"]

    def remember_rests(self) -> None:
        self.rests |= {scenes.rest_of(obj) for obj in self.meshes()}

    def check(self) -> None:
        for obj in self.meshes():
            if obj.mode != "OBJECT":  # an undo has led back into it: what is dragged there changes the rest shape
                self.edited.add(obj.name)
                continue
            if obj.name in self.edited:
                self.edited.remove(obj.name)
                self.rests.add(scenes.rest_of(obj))
            shown = scenes.shown_positions(obj)
            assert np.isfinite(shown).all(), f"{obj.name} is not finite"
            assert np.abs(shown).max() < FAR, f"{obj.name} is out of sight"
            assert scenes.rest_of(obj) in self.rests, f"the rest shape of {obj.name} has changed"

    def is_in_object_mode(self) -> bool:
        active = bpy.context.view_layer.objects.active
        return active is None or active.mode == "OBJECT"

    def pick(self, objects: list[bpy.types.Object]) -> bpy.types.Object | None:
        return self.random.choice(sorted(objects, key=lambda obj: obj.name)) if objects else None

    def pixel(self) -> tuple[int, int]:
        region = self.ui.region()
        x, y = self.random.uniform(0.2, 0.7), self.random.uniform(0.2, 0.8)
        return region.x + round(region.width * x), region.y + round(region.height * y)

    # What it does.
    def select(self) -> Steps:
        objects = [obj for obj in bpy.context.view_layer.objects if obj is not None and obj.visible_get()]
        chosen = self.pick(objects)
        if chosen is not None and self.is_in_object_mode():
            self.ui.select(chosen)
        yield

    def drag_object(self) -> Steps:
        """G or R with the mouse, confirmed or not."""
        yield from self.ui.move_mouse(*self.pixel())
        yield from self.ui.key(self.random.choice("GGR"))
        for _ in range(self.random.randint(1, 3)):
            yield from self.ui.move_mouse(*self.pixel())
        yield from self.ui.key(self.random.choice(("LEFTMOUSE", "RET", "ESC", "RIGHTMOUSE")))

    def drag_surface(self) -> Steps:
        """The left button, with whichever tool is in hand."""
        modifiers = self.random.choice(({}, {}, {"shift": True}, {"ctrl": True}))
        yield from self.ui.move_mouse(*self.pixel())
        self.ui.event("LEFTMOUSE", "PRESS", **modifiers)
        yield
        for _ in range(self.random.randint(1, 4)):
            self.ui.mouse = self.pixel()
            self.ui.event("MOUSEMOVE", "NOTHING", **modifiers)
            yield
        if self.random.random() < 0.2:
            yield from self.ui.key(self.random.choice(("Y", "Z", "ESC", "RIGHTMOUSE", "WHEELUPMOUSE")))
        self.ui.event("LEFTMOUSE", "RELEASE")
        yield

    def click_surface(self) -> Steps:
        yield from self.ui.move_mouse(*self.pixel())
        yield from self.ui.key("LEFTMOUSE", ctrl=self.random.random() < 0.3)

    def undo(self) -> Steps:
        yield from self.ui.key("Z", ctrl=True)

    def redo(self) -> Steps:
        yield from self.ui.key("Z", ctrl=True, shift=True)

    def begin_pose(self) -> Steps:
        if self.ui.can(bpy.ops.arap.pose):
            with suppress(RuntimeError):
                self.ui.call(bpy.ops.arap.pose)
        yield

    def enter(self) -> Steps:
        yield from self.ui.key("RET")

    def escape(self) -> Steps:
        yield from self.ui.key("ESC")

    def press_key(self) -> Steps:
        keys = ("F", "LEFT_BRACKET", "RIGHT_BRACKET", "TAB", "SPACE", "PERIOD", "N")
        yield from self.ui.key(self.random.choice(keys))
        yield from self.ui.key("RET")

    def call_operator(self) -> Steps:
        name = self.random.choice(OPERATORS)
        operator = getattr(bpy.ops.arap, name)
        print(f"  {name}")
        if self.ui.can(operator):
            with suppress(RuntimeError):  # how Python hears of an error that an operator reports
                self.ui.call(operator, "EXEC_DEFAULT", True)
        yield
        if name == "apply_pose_as_rest":
            self.remember_rests()

    def switch_follow(self) -> Steps:
        obj = self.pick(self.meshes())
        if obj is not None:
            obj.arap.use_follow = not obj.arap.use_follow
        yield

    def change_frame(self) -> Steps:
        bpy.context.scene.frame_set(self.random.randint(1, 10))
        yield

    def play(self) -> Steps:
        self.ui.call(bpy.ops.screen.animation_play, "EXEC_DEFAULT", True)
        for _ in range(5):
            yield
        if bpy.context.screen.is_animation_playing:
            self.ui.call(bpy.ops.screen.animation_cancel, "EXEC_DEFAULT", True)
        yield

    def change_mode(self) -> Steps:
        active = bpy.context.view_layer.objects.active
        if active is not None and active.type == "MESH" and active.visible_get():
            mode = self.random.choice(("EDIT", "WEIGHT_PAINT", "SCULPT", "OBJECT"))
            self.ui.call(bpy.ops.object.mode_set, "EXEC_DEFAULT", True, mode=mode)
            yield
            active = bpy.context.view_layer.objects.active
            if active is not None:
                self.ui.call(bpy.ops.object.mode_set, "EXEC_DEFAULT", True, mode="OBJECT")
        yield

    def change_setting(self) -> Steps:
        obj = self.pick(self.meshes())
        if obj is not None:
            choices = {
                "rigidity": (1.0, 2.0, 5.0),
                "energy": ("rotation_nodes", "spokes_and_rims", "spokes"),
                "max_iterations": (5, 100),
            }
            name = self.random.choice(list(choices))
            setattr(obj.arap, name, self.random.choice(choices[name]))
        yield

    def rename(self) -> Steps:
        """With a step of undo, as the outliner does: steps of Edit Mode know their object by its name, or crash."""
        obj = self.pick(self.meshes())
        if obj is not None and obj.mode == "OBJECT" and self.is_in_object_mode():
            obj.name = f"Mesh {self.random.randint(0, 99)}"
            bpy.ops.ed.undo_push(message="rename")
        yield

    def rename_group(self) -> Steps:
        """For a moment only, or nothing could be posed any more."""
        obj = self.pick([obj for obj in self.meshes() if obj.vertex_groups])
        if obj is not None:
            name = self.random.choice(sorted(group.name for group in obj.vertex_groups))
            obj.vertex_groups[name].name = "Renamed"
            yield
            yield
            if "Renamed" in obj.vertex_groups:
                obj.vertex_groups["Renamed"].name = name
        yield

    def duplicate(self) -> Steps:
        if len(self.meshes()) < 4 and self.is_in_object_mode() and self.ui.can(bpy.ops.object.duplicate):
            self.ui.call(bpy.ops.object.duplicate, "EXEC_DEFAULT", True)
        yield

    def delete(self) -> Steps:
        if len(self.meshes()) > 1 and self.random.random() < 0.3:
            obj = self.pick(list(bpy.context.view_layer.objects))
            if obj is not None and obj.mode == "OBJECT":
                print(f"  {obj.name}")
                mesh = obj.data if obj.type == "MESH" and obj.data.users == 1 else None
                bpy.data.objects.remove(obj)
                if mesh is not None:  # or Blender saves its shape keys without it, complains on load, and may crash
                    bpy.data.meshes.remove(mesh)
                bpy.ops.ed.undo_push(message="delete")
        yield

    def hide(self) -> Steps:
        obj = self.pick(self.meshes())
        if obj is not None and obj.mode == "OBJECT":
            obj.hide_set(True)
            yield
            yield
            for hidden in self.meshes():
                hidden.hide_set(False)
        yield

    def save_and_open(self) -> Steps:
        self.ui.call(bpy.ops.wm.save_as_mainfile, "EXEC_DEFAULT", True, filepath=str(self.file))
        if self.random.random() < 0.3:
            bpy.ops.wm.open_mainfile(filepath=str(self.file))
        yield
        yield

    def change_scene(self) -> Steps:
        scene = bpy.context.scene
        if self.is_in_object_mode():
            other = bpy.data.scenes.new("Other scene")
            self.ui.window.scene = other
            yield
            yield
            self.ui.window.scene = scene
            bpy.data.scenes.remove(other)
        yield

    def change_radius(self) -> Steps:
        yield from self.ui.key(self.random.choice(("LEFT_BRACKET", "RIGHT_BRACKET")))

    def toggle_mirror(self) -> Steps:
        obj = self.pick(self.meshes())
        if obj is not None:
            obj.data.use_mirror_x = not obj.data.use_mirror_x
        yield

    def run(self, n_acts: int, minutes: float = 0.0) -> Steps:
        """So many acts, and for so long."""
        start = time.monotonic()
        for i in count():
            if i >= n_acts and time.monotonic() - start >= 60.0 * minutes:
                break
            act = self.random.choice(self.acts)
            print(f"{i}: {act.__name__}", flush=True)
            yield from act()
            self.check()
            if not self.meshes():
                yield from self.rest_a_while()
                self.build()
        yield from self.rest_a_while()
        yield from self.ui.screenshot("end")
        self.check()

    def rest_a_while(self) -> Steps:
        """Ends whatever is under way."""
        for _ in range(3):
            yield from self.ui.key("ESC")
        for obj in self.meshes():
            obj.arap.use_follow = False
        yield from self.ui.until_free()


def test_monkey(ui: Ui) -> Steps:
    monkey = Monkey(ui)
    monkey.build()
    yield from ui.open_tab()
    yield from monkey.run(N_ACTS, MINUTES)


def test_monkey_pulls(ui: Ui) -> Steps:
    """ARAP Pull alone: all undone, the mesh is at rest."""
    yield from test_pull.begin(ui, 21)
    for _ in range(20):  # or undo leads back to the cube
        bpy.ops.ed.undo_push(message="scene")
    rest = scenes.key_positions(test_pull.sheet())
    monkey = Monkey(ui)
    monkey.remember_rests()
    pulls = [*[monkey.drag_surface] * 4, *[monkey.click_surface] * 2, monkey.change_radius, monkey.toggle_mirror]
    monkey.acts = [*pulls, *[monkey.undo] * 2, monkey.redo, monkey.select]
    yield from test_pull.pull(ui, (0.3, 0.0, 0.0), (0.3, 0.2, 0.0))
    assert len(test_pull.sheet().arap.pull_pins) == 1, "the tool is in hand"
    yield from monkey.run(60)
    while test_pull.sheet().data.shape_keys is not None or test_pull.sheet().arap.pull_pins:
        yield from ui.undo()
    np.testing.assert_allclose(scenes.shown_positions(test_pull.sheet()), rest, atol=test_pull.NEAR)
