# SPDX-License-Identifier: GPL-3.0-or-later
"""Times what Blender's main loop does while the mouse is moved once in each of its turns.

In a turn Blender handles the mouse and its timers, where the add-on solves; it evaluates the scene; it draws and shows
what has changed. It calls PRE_VIEW of the 3D view once everything for the graphics card has been made and before any
of it is drawn: what follows until the mouse is handled again is the graphics card's, or of what stands for it.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import bpy
from frame_times import Milliseconds, Stopwatch
from harness import MODULE, Steps, Ui

HANDLE = "Blender evaluates the handle"
REST = "checks, the rest"
MESH = "Blender evaluates the mesh, makes what is drawn"
DRAWN = "software OpenGL draws"
WHOLE = "whole frame"
ADDON = "the add-on's part"
ITERATIONS = "its iterations"
WARM_UP = 5  # frames before anything counts


class MainLoop:
    """Moves the mouse once a turn and times the frames: from one solve to the next, with what is drawn between."""

    def __init__(self, ui: Ui, n_iterations: Callable[[], int]) -> None:
        """``n_iterations`` of the last solve."""
        self.rows: Milliseconds = {}
        self._ui = ui
        self._watch = Stopwatch()
        self._n_iterations = n_iterations
        self._depth = 0  # of calls of the add-on's part
        self._begun_at: float | None = None  # the frame
        self._drawn_from: float | None = None
        self._drawn_ms = 0.0
        self._n_left = 0
        self._watch.watch_session(MODULE, ui.session_of("Creature").session)

    def watch_step(self, owner: object, function: str, name: str) -> None:
        """Times a step of the add-on's part that not every act has."""
        self._watch.watch(owner, function, name)

    def watch_act(self, owner: object, *functions: str) -> None:
        """Times what belongs to the add-on's part."""
        for function in functions:
            self._watch.watch(owner, function, ADDON)
            self._note(owner, function)

    def watch_evaluation(self, scene: object) -> None:
        """Takes out of the add-on's part what Blender evaluates because the add-on is the first to look."""
        self._watch.watch(scene, "_depsgraph", HANDLE)

    def move(self, place: Callable[[int], tuple[int, int]], n_frames: int) -> Steps:
        """Moves the mouse to a place for each turn until there are so many frames; the first ones do not count."""
        handler = bpy.types.SpaceView3D.draw_handler_add(self._drawing, (), "WINDOW", "PRE_VIEW")
        self._n_left = n_frames + WARM_UP
        yield from move_each_turn(self._ui, place, lambda: self._n_left == 0)
        bpy.types.SpaceView3D.draw_handler_remove(handler, "WINDOW")
        self.rows = {name: times[WARM_UP:] for name, times in self.rows.items()}

    def _note(self, owner: object, function: str) -> None:
        original = getattr(owner, function)

        def noted(*arguments: object, **keywords: object) -> object:
            if self._depth == 0:
                self._begin_part()
            self._depth += 1
            try:
                return original(*arguments, **keywords)
            finally:
                self._depth -= 1

        setattr(owner, function, noted)

    def _drawing(self) -> None:
        self._drawn_from = time.perf_counter()

    def _begin_part(self) -> None:
        """The mouse, or a timer, is handled: what was drawn is shown by now."""
        now = time.perf_counter()
        if self._drawn_from is None:
            return
        self._drawn_ms += 1e3 * (now - self._drawn_from)
        self._drawn_from = None
        if self._n_left and self._watch.has("solve"):
            self._end_frame(now)

    def _end_frame(self, now: float) -> None:
        steps, drawn, begun_at = self._watch.take(), self._drawn_ms, self._begun_at
        self._drawn_ms, self._begun_at = 0.0, now
        if begun_at is None:  # the mouse has only begun to move
            return
        whole = 1e3 * (now - begun_at)
        handle = steps.pop(HANDLE, 0.0)
        addon = steps.pop(ADDON) - handle
        frame = {HANDLE: handle, **steps, REST: addon - sum(steps.values())}
        frame |= {MESH: whole - handle - addon - drawn, DRAWN: drawn, WHOLE: whole, ADDON: addon}
        frame[ITERATIONS] = float(self._n_iterations())
        for name, value in frame.items():
            self.rows.setdefault(name, []).append(value)
        self._n_left -= 1


def move_each_turn(ui: Ui, place: Callable[[int], tuple[int, int]], is_done: Callable[[], bool]) -> Steps:
    """One move of the mouse in each turn of the main loop, until all is done."""
    n_turns = 0

    def turn() -> float | None:
        nonlocal n_turns
        if is_done():
            return None
        ui.mouse = place(n_turns)
        ui.event("MOUSEMOVE", "NOTHING")
        n_turns += 1
        return 0.0

    bpy.app.timers.register(turn, first_interval=0.0)
    yield from ui.until(is_done, "all frames are drawn")
