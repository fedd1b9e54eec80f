# SPDX-License-Identifier: GPL-3.0-or-later
"""Follow of one object: the mesh follows its handles all the time. FollowScene stands for Blender.

Handlers tell that the scene was evaluated. A timer goes on if that was not enough. While the artist moves a handle, and
during playback, each solve goes on from the one before. After a change of frame it starts from rest: so a frame looks
the same from whichever frame one comes.

A run of an opened file waits until something moves: the saved pose is that of the handles as they were saved. So a file
is opened at once, and to look at it does not change it. After an undo that leaves no pose a run waits, too.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from enum import Enum, auto
from functools import partial
from typing import Protocol

from ..core.tracker import (
    BIND_STEP_S,
    FOLLOW_TIME_LIMIT_S,
    REFINE_TIME_LIMIT_S,
    BindProgress,
    EngineScene,
    HandleTracker,
)

# A mesh whose step takes longer than this lets Blender work for as long before its next one.
HEAVY_STEP_S = 0.03
MOST_STEPS_OF_BINDING = 6  # two binds: if the session does not fit then, it never will


class NotNow(Exception):
    """The mesh cannot follow until something changes. Says why in a few words. Follow stays on."""


class When(Enum):
    """What has evaluated the scene."""

    UPDATE = auto()  # something has changed
    FRAME = auto()  # another frame: one step, a script, or a viewport render, which shows it before the timer runs
    SCRUB = auto()  # another frame, because the playhead is dragged
    PLAYBACK = auto()


class FollowScene(EngineScene, Protocol):
    """What Follow needs of Blender, for one object."""

    def has_changed(self) -> bool:
        """Whether anything that the pose depends on has changed since the first call. Changes nothing itself."""

    def look_again(self) -> None:
        """Anything may have changed, for example the mode."""

    def undone(self) -> bool:
        """As look_again(), and all data has new addresses.

        Returns:
            Whether there is a pose. If not, has_changed() starts over.
        """

    def switch_off(self, error: Exception) -> None:
        """Follow cannot go on: switches it off and says why."""


class FollowRun(BindProgress):
    """From the moment that Follow is switched on until ``is_over``. No method raises."""

    def __init__(
        self, scene: FollowScene, clock: Callable[[], float] = time.perf_counter, *, is_waiting: bool = False
    ) -> None:
        """Prepares it. ``is_waiting``: until something moves, the pose shown is the right one."""
        self._scene = scene
        self._is_waiting = is_waiting
        self._clock = clock
        self._tracker = HandleTracker(scene, clock)
        self._is_busy = False
        self._is_resuming = True  # the next step begins with the pose that the key shows
        self._is_from_rest = False  # the next step starts from rest
        self._is_behind = False  # a handler had to leave a step to the timer
        self._is_played = False  # the pose shown was solved during playback
        self._free_at = 0.0
        self.pause = ""
        self.is_over = False

    @property
    def is_settled(self) -> bool:
        """Whether there is nothing left to do until something changes."""
        is_busy = self.is_binding or self._is_resuming or self._is_behind or self._is_played
        return self._is_waiting or (self._tracker.is_settled and not is_busy)

    @property
    def wants_timer(self) -> bool:
        return not self.is_over and (bool(self.pause) or not self.is_settled)

    def scene_changed(self, when: When, time_limit_s: float = FOLLOW_TIME_LIMIT_S) -> None:
        """Follows the handles if they have moved. A frame that is shown alone is settled at once, if it is bound."""
        if when is When.FRAME:
            self._guarded(partial(self._settle, BIND_STEP_S, has_timer=True))
            return
        if when is When.SCRUB:
            self._is_from_rest = True
        self._guarded(partial(self._follow_in_time, when, time_limit_s))

    def settle(self, bind_limit_s: float) -> None:
        """Binds if it must, and solves to the end. There is no timer: a bind that takes longer ends the run."""
        self._guarded(partial(self._settle, bind_limit_s, has_timer=False))

    def look(self) -> None:
        """For a run that waits: a first look, at what must change."""
        self._guarded(lambda: None)

    def tick(self, *, is_playing: bool, time_limit_s: float = REFINE_TIME_LIMIT_S) -> None:
        """A step of binding, following or refining. During playback only of binding."""
        self._guarded(partial(self._tick, time_limit_s, is_playing=is_playing))

    def undone(self) -> None:
        """Goes on from the pose that undo or redo has brought, or waits if it has brought none. All data is new."""
        self._is_resuming = True
        has_pose = self._scene.undone()
        self._is_waiting = self._is_waiting or not has_pose

    def end(self) -> None:
        """Switched off, or the object is gone."""
        self.is_over = True
        self._tracker.drop()

    def _guarded(self, step: Callable[[], object]) -> None:
        # Reading evaluated matrices evaluates the scene, which calls scene_changed() within tick().
        if self.is_over or self._is_busy:
            return
        self._is_busy = True
        try:
            self.pause = self._scene.look()
            if self._is_waiting:  # in a pause, too: what changes meanwhile counts
                self._is_waiting = not self._scene.has_changed()
            if not (self._is_waiting or self.pause):
                step()
        except NotNow as reason:
            self.pause = str(reason)
        except Exception as error:  # noqa: BLE001 - whatever it is, say it once and not at every step
            self.end()
            self._scene.switch_off(error)
        finally:
            self._is_busy = False
        if self.pause:
            self._is_resuming = True
            self._scene.look_again()

    def _follow_in_time(self, when: When, time_limit_s: float) -> None:
        self._is_behind = self._clock() < self._free_at or not self._tracker.is_ready()
        if self._is_behind or self._timed(partial(self._follow, time_limit_s)):
            self._is_played = self._is_played or when is When.PLAYBACK

    def _tick(self, time_limit_s: float, *, is_playing: bool) -> None:
        if self._clock() < self._free_at or not self._tracker.prepare() or is_playing:
            return
        if self._is_played:
            self._is_played, self._is_from_rest = False, True
            self._tracker.forget_place()
        self._is_behind = False
        self._timed(partial(self._follow_or_refine, time_limit_s))

    def _follow_or_refine(self, time_limit_s: float) -> bool:
        has_moved = self._follow(FOLLOW_TIME_LIMIT_S)
        if not has_moved:
            self._tracker.refine(time_limit_s)
        return has_moved

    def _settle(self, bind_limit_s: float, *, has_timer: bool) -> None:
        self._is_from_rest = True  # without a time limit there is no drag
        self._is_behind = self._scene.has_to_wait()
        if self._is_behind:
            return
        for _ in range(MOST_STEPS_OF_BINDING):
            was_binding = self.is_binding
            if self._tracker.prepare(bind_limit_s):
                self._follow(None)
                self._is_played = False
                return
            if was_binding and self.is_binding:
                if not has_timer:
                    raise RuntimeError(f"The mesh was not prepared within {bind_limit_s:g} seconds: use Solve or Bake")
                self._is_behind = True
                return
            self._scene.look()
        raise RuntimeError("The mesh changes each time it has been prepared")

    def _follow(self, time_limit_s: float | None) -> bool:
        if self._is_resuming:
            self._is_resuming = False
            self._tracker.go_on_from_shown()
        is_from_rest, self._is_from_rest = self._is_from_rest, False
        return self._tracker.follow(time_limit_s, is_from_rest=is_from_rest)

    def _timed(self, step: Callable[[], bool]) -> bool:
        """Does a step. After a heavy one Blender has as much time before the next."""
        start = self._clock()
        has_moved = step()
        end = self._clock()
        self._free_at = end + (end - start) if end - start > HEAVY_STEP_S else 0.0
        return has_moved
