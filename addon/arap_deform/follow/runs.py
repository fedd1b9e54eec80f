# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects follow, and what drives them: handlers, and a timer while there is work left.

No modal operator: while one runs, Blender does not save automatically.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Sequence
from contextlib import suppress
from functools import partial

import bpy
from bpy.app.handlers import persistent

from ..core import sessions
from ..core.tracker import FOLLOW_TIME_LIMIT_S
from ..engine.scene import is_playing, is_rendering
from ..props import hooks, preferences
from ..scene import known, meshes, pose_key, redraw, undo_step
from ..scene.console import say
from ..scene.registration import for_each
from ..ui import waiting
from ..ui.esc import EndedByEsc, is_free
from ..ui.waits import Wait, wait_for_bind
from .run import FollowRun, When
from .scene import PAUSING_MODES, SCRIPT_TIME_LIMIT_S, BlenderFollowScene

TIMER_S = 0.02
FOLLOW = "Follow"  # see sessions.hold()
SLOW_TIMER_S = 0.2  # while it only waits for the end of a pause, a playback or a render

NOT_RENDERED = "Rendered without Follow: the mesh kept one shape. Bake the animation before rendering it"


class Run(FollowRun, EndedByEsc):
    """The run of one object, and its scene."""

    def __init__(self, obj: bpy.types.Object, *, is_waiting: bool) -> None:
        self.scene = BlenderFollowScene(obj)
        super().__init__(self.scene, is_waiting=is_waiting)
        sessions.hold(self.scene.uid, FOLLOW)

    def wait(self) -> Wait | None:
        if self.pause or is_rendering():
            return None
        return wait_for_bind(self.scene.name, self, ends_on_esc=is_free())

    def cancel(self) -> str:
        obj = self.scene.obj
        if obj is None:
            return ""
        obj.arap.use_follow = False
        return f"Preparing '{obj.name}' cancelled: Follow is off, and nothing has moved"

    def end(self) -> None:
        super().end()
        sessions.release(self.scene.uid, FOLLOW)


_runs: dict[int, Run] = {}  # by uid of the object
_render_frame: int | None = None  # the first one of a render under way
_has_rendered_without = False


def run_of(obj: bpy.types.Object) -> Run | None:
    """The object's run, None if it does not follow."""
    return _runs.get(obj.session_uid)


def render_notice() -> str:
    """What the panel says about the last render, '' if the render was right."""
    return NOT_RENDERED if _has_rendered_without else ""


def toggled(obj: bpy.types.Object) -> None:
    """The object's toggle was changed, by hand or by a script."""
    obj.arap.follow_error = ""
    if obj.arap.use_follow:
        _make_key(obj)
        _begin(obj)
        obj.update_tag()  # so that the next evaluation, of a script for example, makes the mesh follow
    else:
        forget(obj.session_uid)


def _make_key(obj: bpy.types.Object) -> None:
    """Makes the pose key now, so that it belongs to the same step of undo. If it cannot be, Follow says why."""
    is_ours = obj.type == "MESH" and obj.library is None
    if is_ours and obj.mode not in PAUSING_MODES and not obj.data.is_editmode:
        with suppress(ValueError):
            pose_key.writable(obj)


def clear_follow_error(obj: bpy.types.Object) -> None:
    """Call it before a task without Follow: undoing the task must not try again what Follow has given up."""
    if obj.arap.follow_error:
        obj.arap.follow_error = ""
        undo_step.push("ARAP Follow Off")


def _begin(obj: bpy.types.Object, *, is_waiting: bool = False) -> None:
    if obj.session_uid not in _runs and _is_own(obj) and obj.type == "MESH":
        _runs[obj.session_uid] = Run(obj, is_waiting=is_waiting)
        _wake()


def _is_own(obj: bpy.types.Object) -> bool:
    """Whether it may be changed: not an object of a library, nor an override of one."""
    return obj.library is None and not meshes.is_override(obj)


def forget(uid: int) -> None:
    """The object is gone, or does not follow any more."""
    if uid in _runs:
        _runs.pop(uid).end()


def _find(objects: Iterable[bpy.types.Object]) -> None:
    """Ends the runs whose object is gone or does not follow any more, and begins one for each that does."""
    for uid, run in list(_runs.items()):
        obj = run.scene.obj
        if obj is None or not obj.arap.use_follow:
            forget(uid)
            if obj is None:
                sessions.drop(uid)
    for_each((obj for obj in objects if obj.arap.use_follow), _begin)


def _changed(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, when: When, updates: Sequence[known.Update] | None
) -> None:
    runs = [run for run in _runs.values() if known.is_in(scene, run.scene.obj)]
    n_moving = sum(not (run.is_settled or run.pause) for run in runs)

    def follow(run: Run) -> None:
        with run.scene.evaluated(depsgraph, updates):
            if bpy.app.background:  # there are no timers
                run.settle(SCRIPT_TIME_LIMIT_S)
            else:
                run.scene_changed(when, FOLLOW_TIME_LIMIT_S / max(1, n_moving))

    for_each(runs, follow)
    _wake()


def _is_render() -> bool:
    return is_rendering() or _render_frame is not None


def scene_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, updates: Sequence[known.Update]) -> None:
    """After an evaluation."""
    if _is_render():
        return
    _find(update.obj for update in updates)
    if _runs:
        _changed(scene, depsgraph, When.UPDATE, updates)


def frame_changed(scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
    global _has_rendered_without  # noqa: PLW0603 - set by one handler and read by the panel
    if _is_render():
        if _runs and scene.frame_current != _render_frame and not _has_rendered_without:
            _has_rendered_without = True
            say(f"ARAP: {NOT_RENDERED}")
    elif _runs:
        _changed(scene, depsgraph, _how_frame_changed(), None)


def undone(scene: bpy.types.Scene) -> None:
    """After an undo."""
    for obj in known.all_objects():
        # Undo goes back in the whole file. Where the artist does not look, it must switch nothing on.
        is_elsewhere = obj.arap.use_follow and obj.session_uid not in _runs and not known.is_in(scene, obj)
        if is_elsewhere and _is_own(obj):
            obj.arap.use_follow = False
            obj.arap.follow_error = "An undo in another scene would have switched it on: Follow is off"
    _find(known.all_objects())
    for_each(_runs.values(), Run.undone)
    _wake()


def loaded() -> None:
    """Another file was loaded."""
    global _render_frame, _has_rendered_without
    _render_frame, _has_rendered_without = None, False
    for_each(_runs.values(), Run.end)
    _runs.clear()
    sessions.clear()  # after the runs: one that ends while it binds gives its former session back
    for_each((obj for obj in known.all_objects() if obj.arap.use_follow), partial(_begin, is_waiting=True))
    for_each(list(_runs.values()), Run.look)


@persistent
def _on_render_begin(scene: bpy.types.Scene, *_: object) -> None:
    global _render_frame, _has_rendered_without
    _render_frame, _has_rendered_without = scene.frame_current, False


@persistent
def _on_render_end(*_: object) -> None:
    global _render_frame  # noqa: PLW0603 - as above
    _render_frame = None


def _how_frame_changed() -> When:
    if is_playing():
        return When.PLAYBACK
    # A viewport render does not tell of itself: it is a change of frame like any other.
    return When.SCRUB if any(w.screen.is_scrubbing for w in bpy.context.window_manager.windows) else When.FRAME


def _wake() -> None:
    if any(run.wants_timer for run in _runs.values()) and not bpy.app.timers.is_registered(_on_timer):
        bpy.app.timers.register(_on_timer, first_interval=0.0, persistent=True)


def _on_timer() -> float | None:
    if _is_render():
        return SLOW_TIMER_S
    _find(())
    start = time.perf_counter()
    shown = _shown()
    playing = is_playing()
    runs = [run for run in _runs.values() if run.wants_timer]
    step_s = preferences.refine_time_s() / max(1, len(runs))
    for_each(runs, lambda run: run.tick(is_playing=playing, time_limit_s=step_s))
    if _shown() != shown:
        redraw.tag_panels()
    left = [run for run in _runs.values() if run.wants_timer]
    for run in left:
        if run.wait() is not None:
            waiting.watch(run)
    if not left:
        return None
    if all(run.pause or (playing and not run.is_binding) for run in left):
        return SLOW_TIMER_S
    return max(TIMER_S, time.perf_counter() - start)  # Blender gets half of the time


def _shown() -> list[tuple[object, ...]]:
    """What a panel shows of the runs."""
    return [
        (uid, run.pause, run.is_settled, run.is_binding, f"{run.bind_fraction:.0%}", run.stats)
        for uid, run in _runs.items()
    ]


CALLBACKS = (
    (hooks.follow_toggled, toggled),
    (bpy.app.handlers.render_init, _on_render_begin),
    (bpy.app.handlers.render_complete, _on_render_end),
    (bpy.app.handlers.render_cancel, _on_render_end),
)


def register() -> None:
    """Follow goes on after the add-on was switched off and on. Later, because no data can be read now."""
    bpy.app.timers.register(_begin_all, first_interval=0.0, persistent=True)


def _begin_all() -> None:
    known.look_again()
    _find(known.all_objects())
    _wake()


def unregister() -> None:
    if bpy.app.timers.is_registered(_begin_all):
        bpy.app.timers.unregister(_begin_all)
    if bpy.app.timers.is_registered(_on_timer):
        bpy.app.timers.unregister(_on_timer)
    for run in _runs.values():
        run.end()
    _runs.clear()
