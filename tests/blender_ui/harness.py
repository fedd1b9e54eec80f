# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender: installs the zip, or runs tests of one file in a real window, one after the other.

A test is a generator function of one argument, the Ui. Each ``yield`` lets Blender handle the events simulated so far
and draw: TICKS_A_STEP turns of its main loop. Each test begins in the factory's home file. Blender tells the runner on
its standard output which test begins and how it ended. A test that failed ends Blender: nobody knows what it has left
behind.
"""

from __future__ import annotations

import contextlib
import importlib
import subprocess
import sys
import time
import traceback
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import bpy
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

HERE = Path(__file__).resolve().parent
if str(HERE) not in sys.path:
    sys.path.insert(0, str(HERE))
    sys.path.append(str(HERE.parent / "blender"))  # frame_times, which the measurements share
import gate  # noqa: E402 - Blender runs this file from elsewhere
from gate import Gate  # noqa: E402

TICKS_A_STEP = 4  # an event takes up to this many turns of the main loop until everything has seen it
HANG_LIMIT_S = 300.0  # nothing that a test waits for takes nearly as long, on any machine
BEGINS, PASSED, FAILED = "UI TEST BEGINS", "UI TEST PASSED", "UI TEST FAILED"
MODULE = "bl_ext.user_default.arap_deform"

Steps = Iterator[None]


def install(zip_path: str) -> None:
    bpy.ops.extensions.package_install_files(filepath=zip_path, repo="user_default", enable_on_install=False)
    bpy.ops.preferences.addon_enable(module=MODULE)
    if MODULE not in bpy.context.preferences.addons:
        raise RuntimeError(f"{MODULE} cannot be enabled after its installation")


class Ui:
    """The window as a test sees it: events in, pictures out. Coordinates are pixels from the lower left corner."""

    def __init__(self, screenshots: Path) -> None:
        self.screenshots = screenshots
        self.mouse = (0, 0)
        self._test = ""
        self._at_end: list[Callable[[], object]] = []
        self._gate: Gate | None = None
        self.find_modules()

    def begin(self, test: str) -> None:
        self._test = test
        self._at_end.clear()
        prepare_window()

    def end(self) -> Steps:
        """Takes back what the test has changed outside of the file, and loads the home file."""
        while self._at_end:
            self._at_end.pop()()
        bpy.ops.wm.read_homefile(use_factory_startup=True)
        yield
        assert not self.running, f"still under way in a new file: {self.running}"

    def change(self, owner: Any, name: str, value: object) -> None:
        """Sets a preference, or something of the add-on's code, until the end of the test."""
        before = getattr(owner, name)
        if isinstance(before, bpy.types.bpy_prop_array):
            before = tuple(before)
        self._at_end.append(lambda: setattr(owner, name, before))
        setattr(owner, name, value)

    def change_pull(self, name: str, value: object) -> None:
        """The same for a setting of ARAP Pull, asked for again: what the add-on has is freed when it is disabled."""
        before = getattr(self.preferences.pull(), name)
        self._at_end.append(lambda: setattr(self.preferences.pull(), name, before))
        setattr(self.preferences.pull(), name, value)

    def find_modules(self) -> None:
        """The add-on's own modules; again after it was disabled and enabled."""
        self.api: Any = importlib.import_module(f"{MODULE}.api")
        self.tracker: Any = importlib.import_module(f"{MODULE}.core.tracker")
        self.sessions: Any = importlib.import_module(f"{MODULE}.core.sessions")
        self.background: Any = importlib.import_module(f"{MODULE}.core.background")
        self.handle_motion: Any = importlib.import_module(f"{MODULE}.scene.handle_motion")
        self.meshes: Any = importlib.import_module(f"{MODULE}.scene.meshes")
        self.pose_key: Any = importlib.import_module(f"{MODULE}.scene.pose_key")
        self.follow: Any = importlib.import_module(f"{MODULE}.follow.runs")
        self.follow_run: Any = importlib.import_module(f"{MODULE}.follow.run")
        self.overlay: Any = importlib.import_module(f"{MODULE}.show.overlay")
        self.solve: Any = importlib.import_module(f"{MODULE}.pose.solve")
        self.preferences: Any = importlib.import_module(f"{MODULE}.props.preferences")
        self.pull: Any = importlib.import_module(f"{MODULE}.pull.run")
        self.pull_tool: Any = importlib.import_module(f"{MODULE}.pull.tool")
        self.shapes_job: Any = importlib.import_module(f"{MODULE}.bake.shapes_job")
        self.waiting: Any = importlib.import_module(f"{MODULE}.ui.waiting")
        self.known: Any = importlib.import_module(f"{MODULE}.scene.known")

    @property
    def running(self) -> dict[str, Any]:
        """The acts under way, by the names of their objects."""
        found = {uid: self.known.find(uid) for uid in self.sessions.locks}
        return {obj.name if obj else str(uid): self.sessions.locks[uid] for uid, obj in found.items()}

    def session_of(self, name: str) -> Any:
        """The live session of the object of that name, with what it was made from."""
        return self.sessions.get(bpy.data.objects[name].session_uid)

    @contextlib.contextmanager
    def _held(self, holding: AbstractContextManager[Gate]) -> Iterator[Gate]:
        with holding as self._gate:
            yield self._gate
        self._gate = None

    def held_stage(self, *, after: float = 0.0) -> AbstractContextManager[Gate]:
        """As gate.held_stage()."""
        return self._held(gate.held_stage(self.background.Stage, after=after))

    def held_shapes(self) -> AbstractContextManager[Gate]:
        """As gate.held_shapes()."""
        return self._held(gate.held_shapes(self.shapes_job.ShapesJob))

    def held_settling(self) -> AbstractContextManager[Gate]:
        """As gate.held_settling()."""
        return self._held(gate.held_settling(self.tracker.HandleTracker))

    @property
    def window(self) -> bpy.types.Window:
        return bpy.context.window_manager.windows[0]

    @property
    def view(self) -> bpy.types.Area:
        return next(area for area in self.window.screen.areas if area.type == "VIEW_3D")

    def region(self, kind: str = "WINDOW") -> bpy.types.Region:
        return next(region for region in self.view.regions if region.type == kind)

    def event(self, kind: str, value: str = "PRESS", **modifiers: bool | str) -> None:
        self.window.event_simulate(type=kind, value=value, x=self.mouse[0], y=self.mouse[1], **modifiers)

    def press(self, kind: str, **modifiers: bool) -> None:
        """A key down and up."""
        self.event(kind, "PRESS", **modifiers)
        self.event(kind, "RELEASE", **modifiers)

    def press_letter(self, letter: str) -> None:
        names = {**{str(i): name for i, name in enumerate(DIGITS)}, " ": "SPACE", ".": "PERIOD", "-": "MINUS"}
        self.event(names.get(letter, letter.upper()), "PRESS", unicode=letter)
        self.event(names.get(letter, letter.upper()), "RELEASE")

    def key(self, kind: str, **modifiers: bool) -> Steps:
        self.press(kind, **modifiers)
        yield

    def undo(self) -> Steps:
        yield from self.key("Z", ctrl=True)
        yield

    def redo(self) -> Steps:
        yield from self.key("Z", ctrl=True, shift=True)
        yield

    def text(self, text: str) -> Steps:
        for letter in text:
            self.press_letter(letter)
        yield

    def move_mouse(self, x: int, y: int) -> Steps:
        self.mouse = (x, y)
        self.event("MOUSEMOVE", "NOTHING")
        yield

    def pixel(self, place: Sequence[float]) -> tuple[int, int]:
        """Where a place in the world is seen."""
        region = self.region()
        x, y = location_3d_to_region_2d(region, self.view.spaces.active.region_3d, Vector(place))
        return round(region.x + x), round(region.y + y)

    def move_mouse_to_view(self) -> Steps:
        region = self.region()
        yield from self.move_mouse(region.x + region.width // 3, region.y + region.height // 2)

    def until(self, is_true: Callable[[], bool], what: str) -> Steps:
        """Waits until something is true."""
        end = time.monotonic() + HANG_LIMIT_S
        while not is_true():
            if time.monotonic() > end:
                raise AssertionError(f"{what}: not after {HANG_LIMIT_S:g} s")
            yield

    def until_free(self) -> Steps:
        """Waits until no act has a mesh for itself."""
        yield from self.until(lambda: not self.running, "all acts have ended")

    def until_held(self) -> Steps:
        """Waits until the gate holds some work."""
        yield from self.until(lambda: self._gate is not None and self._gate.is_holding, "the work is under way")

    def until_bar(self, begins_with: str) -> Steps:
        """Waits until the bar of what the artist waits for is there."""
        yield from self.until(lambda: self.waiting.shown() is not None, "the bar is there")
        text = self.waiting.shown()[1].text
        assert text.startswith(begins_with), text

    def until_no_bar(self) -> Steps:
        yield from self.until(lambda: self.waiting.shown() is None, "the bar is gone")

    @contextlib.contextmanager
    def override(self, **members: Any) -> Iterator[None]:
        """Blender's own override of the context; by default that of a button in the 3D view."""
        members = members or {"window": self.window, "area": self.view, "region": self.region()}
        with bpy.context.temp_override(**members):
            yield

    def call(self, operator: Any, *args: Any, **properties: Any) -> set[str]:
        """Calls an operator as a button in the 3D view would."""
        with self.override():
            return operator(*(args or ("INVOKE_DEFAULT", True)), **properties)

    def can(self, operator: Any) -> bool:
        """Whether a button in the 3D view could call an operator."""
        with self.override():
            return bool(operator.poll())

    def select(self, *objects: bpy.types.Object) -> None:
        """Selects objects; the last one is the active one."""
        bpy.context.view_layer.update()  # or an object removed just now is still among them, as None
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in objects)
        bpy.context.view_layer.objects.active = objects[-1]

    def open_panels(self, *names: str) -> None:
        """Of the tab, which has not been drawn yet, these sub-panels are open, and no other ones."""
        before = {cls: getattr(cls, "bl_options", set()) for cls in sub_panels()}
        assert set(names) <= {cls.__name__ for cls in before}, names
        self._at_end.append(lambda: register_again(before))
        register_again({cls: set() if cls.__name__ in names else {"DEFAULT_CLOSED"} for cls in before})

    def open_tab(self) -> Steps:
        """Opens the sidebar on the add-on's tab, and sees that its panel is drawn."""
        panel = bpy.types.ARAP_PT_main
        draw, n_drawn = panel.draw, 0

        def counted_draw(self: bpy.types.Panel, context: bpy.types.Context) -> None:
            nonlocal n_drawn
            n_drawn += 1
            draw(self, context)

        panel.draw = counted_draw
        self.view.spaces.active.show_region_ui = True
        yield  # the tabs are there once they were drawn
        yield
        region = self.region("UI")
        region.active_panel_category = "ARAP"
        region.tag_redraw()
        yield from self.until(lambda: n_drawn > 0, "the tab is shown")
        panel.draw = draw
        yield from self.move_mouse_to_view()

    def scroll_tab(self) -> Steps:
        """To its end."""
        region = self.region("UI")
        yield from self.move_mouse(region.x + region.width // 3, region.y + region.height // 2)
        for _ in range(60):
            self.event("WHEELDOWNMOUSE")
            yield

    def turn_view_into_preferences(self) -> Generator[None, None, bpy.types.Area]:
        """Shows the add-on's page of preferences where the 3D view was; returns the area."""
        area = self.view
        bpy.context.window_manager.addon_search = "ARAP"
        bpy.context.preferences.active_section = "ADDONS"
        area.type = "PREFERENCES"
        yield  # Blender knows its add-ons once their list was drawn
        bpy.ops.preferences.addon_expand(module=MODULE)
        area.tag_redraw()
        yield
        return area

    def screenshot(self, name: str) -> Steps:
        yield  # so that all is drawn
        path = self.screenshots / f"{self._test}_{name}.png"
        subprocess.run(["import", "-window", "root", str(path)], check=True)


DIGITS = ("ZERO", "ONE", "TWO", "THREE", "FOUR", "FIVE", "SIX", "SEVEN", "EIGHT", "NINE")


def sub_panels() -> list[Any]:
    """All of the tab's, parents first."""
    found = [cls for cls in bpy.types.Panel.__subclasses__() if hasattr(cls, "bl_parent_id") and cls.is_registered]
    found = [cls for cls in found if getattr(cls, "bl_category", "") == "ARAP"]
    found = [cls for cls in found if "HIDE_HEADER" not in getattr(cls, "bl_options", ())]  # it is always open
    return sorted(found, key=lambda cls: cls.bl_parent_id != "ARAP_PT_main")


def register_again(options: dict[Any, set[str]]) -> None:
    """Registers panels, parents first, with other options: Blender asks for them when it first draws a panel."""
    for cls in reversed(options):
        bpy.utils.unregister_class(cls)
    for cls, its_options in options.items():
        cls.bl_options = its_options
        bpy.utils.register_class(cls)


def prepare_window() -> None:
    """Nothing that costs time or takes the first event."""
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    preferences.view.smooth_view = 0
    preferences.system.viewport_aa = "OFF"
    preferences.view.show_tooltips = False


def steps_of(ui: Ui, module: str, names: Sequence[str]) -> Steps:
    """All tests, one after the other. Where one fails, the rest is left to another Blender."""
    tests = importlib.import_module(module)
    for name in names:
        print(BEGINS, name, flush=True)
        ui.begin(name)
        try:
            yield from getattr(tests, name)(ui)
            yield from ui.end()
        except Exception:  # noqa: BLE001 - whatever it is, the test has failed
            traceback.print_exc()
            yield from ui.screenshot("failed")
            print(FAILED, name, flush=True)
            sys.exit(1)
        print(PASSED, name, flush=True)


def run(module: str, screenshots: str, names: Sequence[str]) -> None:
    prepare_window()
    bpy.ops.preferences.addon_enable(module=MODULE)
    steps = steps_of(Ui(Path(screenshots)), module, names)
    ticks = 0

    def tick() -> float:
        nonlocal ticks
        ticks += 1
        try:
            if ticks % TICKS_A_STEP == 0 and next(steps, "end") == "end":
                sys.exit(0)
        except Exception:  # noqa: BLE001 - a timer that raises is no more called
            traceback.print_exc()
            sys.exit(1)
        return 0.0

    bpy.app.timers.register(tick, first_interval=0.1, persistent=True)


def main(arguments: Sequence[str]) -> None:
    if arguments[0] == "install":
        install(arguments[1])
    else:
        run(arguments[1], arguments[2], arguments[3:])


if __name__ == "__main__":
    main(sys.argv[sys.argv.index("--") + 1 :])
