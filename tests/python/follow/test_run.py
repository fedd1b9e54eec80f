# SPDX-License-Identifier: GPL-3.0-or-later
"""Follow of one object without Blender: a fake scene and a fake clock stand for it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import pytest
from arap_deform.core.session_data import SolveStats
from arap_deform.core.tracker import FOLLOW_TIME_LIMIT_S
from arap_deform.follow.run import HEAVY_STEP_S, FollowRun, NotNow, When
from fake_engine import FakeBind, FakeEngineScene, evaluate_with_matrices


@dataclass
class FakeScene(FakeEngineScene):
    """The scene of a run, with a clock: ``now``."""

    pause: str = ""
    step_s: float = 0.001
    now: float = 0.0
    off: list[str] = field(default_factory=list)
    first_place: float | None = None
    has_pose: bool = True

    def clock(self) -> float:
        return self.now

    def look(self) -> str:
        return self.pause

    def look_again(self) -> None:
        self.calls.append("look again")

    def has_changed(self) -> bool:
        self.first_place = self.place if self.first_place is None else self.first_place
        return self.place != self.first_place

    def undone(self) -> bool:
        self.calls.append("undone")
        self.first_place = self.first_place if self.has_pose else None
        return self.has_pose

    def switch_off(self, error: Exception) -> None:
        self.off.append(str(error))

    def solved(self, call: str) -> SolveStats:
        done = super().solved(call)
        self.now += self.step_s
        return replace(done, last_ms=1e3 * self.step_s)


def begin(**scene_options: Any) -> tuple[FakeScene, FollowRun]:
    scene = FakeScene(**scene_options)
    return scene, FollowRun(scene, scene.clock)


def begun(**scene_options: Any) -> tuple[FakeScene, FollowRun]:
    """A run that has followed once and settled."""
    scene, run = begin(**scene_options)
    run.tick(is_playing=False)
    assert not run.wants_timer
    scene.calls.clear()
    return scene, run


def test_begins_with_the_pose_shown() -> None:
    scene, run = begin()
    assert run.wants_timer
    run.tick(is_playing=False)
    assert scene.calls == ["go on", "follow"]
    assert not run.wants_timer


def test_what_did_not_change_is_not_solved() -> None:
    scene, run = begun()
    for when in (When.UPDATE, When.FRAME, When.UPDATE, When.PLAYBACK):
        run.scene_changed(when)
    run.settle(60.0)
    assert (scene.calls, run.wants_timer) == ([], False)


def test_a_moved_handle_is_followed_at_once_and_refined_by_the_timer() -> None:
    scene, run = begun()
    scene.place, scene.needed_updates = 1.0, 2
    run.scene_changed(When.UPDATE)
    assert (scene.calls, run.wants_timer) == (["follow"], True)
    run.tick(is_playing=False)
    run.tick(is_playing=False)
    assert (scene.calls, run.wants_timer) == (["follow", "refine"], False)


@pytest.mark.parametrize("when", [When.FRAME, When.SCRUB])
def test_another_frame_starts_from_rest(when: When) -> None:
    scene, run = begun()
    scene.place = 1.0
    run.scene_changed(when)
    scene.place = 2.0
    run.scene_changed(When.UPDATE)
    assert scene.calls == ["from rest", "follow"]


def test_a_frame_shown_alone_is_settled_at_once_even_in_the_pause_of_a_heavy_mesh() -> None:
    scene, run = begun()
    scene.step_s = 1.0
    for place in (1.0, 2.0):
        scene.place = place
        run.scene_changed(When.FRAME)
    assert (scene.calls, scene.limits[1:]) == (["from rest"] * 2, [(None, None)] * 2)
    assert not run.wants_timer


def test_a_frame_shown_alone_does_not_wait_for_a_bind_and_catches_up() -> None:
    scene, run = begin(is_fit=False)
    run.scene_changed(When.FRAME)
    assert (scene.binds[0].is_done, scene.calls, run.wants_timer) == (False, [], True)
    scene.binds[0].is_done = True
    run.tick(is_playing=False)
    run.tick(is_playing=False)
    assert (scene.calls, run.wants_timer) == (["go on", "from rest"], False)


def test_a_frame_shown_alone_is_shown_with_a_bind_that_takes_no_time() -> None:
    scene, run = begin(is_fit=False, bind_needs_s=0.0)
    run.scene_changed(When.FRAME)
    assert (scene.calls, run.wants_timer) == (["go on", "from rest"], False)
    scene.is_painted, scene.place = True, 1.0
    run.scene_changed(When.FRAME)
    assert (scene.calls[2:], run.wants_timer) == ([], True)


def test_without_a_timer_a_bind_is_waited_for_but_not_for_ever() -> None:
    for needs_s, calls in ((1.0, ["go on", "from rest"]), (61.0, [])):
        scene, run = begin(is_fit=False, bind_needs_s=needs_s)
        run.settle(60.0)
        assert scene.calls == calls
        assert (run.is_over, scene.binds[0].is_dropped) == (not calls, not calls)
    assert scene.off == ["The mesh was not prepared within 60 seconds: use Solve or Bake"]


def test_a_run_of_an_opened_file_waits_until_something_moves() -> None:
    scene = FakeScene(is_fit=False)
    run = FollowRun(scene, scene.clock, is_waiting=True)
    run.look()
    for when in (When.UPDATE, When.FRAME, When.UPDATE):
        run.scene_changed(when)
        run.tick(is_playing=False)
    assert (scene.binds, scene.calls, run.is_settled, run.wants_timer) == ([], [], True, False)
    scene.place = 1.0
    run.scene_changed(When.UPDATE)
    assert run.wants_timer
    scene.place = 0.0
    run.tick(is_playing=False)
    assert len(scene.binds) == 1


def test_a_run_that_waits_sees_what_changes_in_a_pause() -> None:
    """As in a file that was saved in Edit Mode."""
    scene = FakeScene(pause="Paused in Edit Mode", place=1.0)
    run = FollowRun(scene, scene.clock, is_waiting=True)
    run.look()
    scene.place = 2.0
    scene.pause = ""
    run.tick(is_playing=False)
    assert scene.calls[-1] == "follow"


def test_playback_goes_on_from_the_frame_before_and_its_last_frame_starts_from_rest() -> None:
    scene, run = begun()
    for place in (1.0, 2.0):
        scene.place, scene.needed_updates = place, 9
        run.scene_changed(When.PLAYBACK)
        run.tick(is_playing=True)  # nothing is refined between the frames
    assert scene.calls == ["follow", "follow"]
    assert run.wants_timer
    scene.needed_updates = 1
    run.tick(is_playing=False)
    assert scene.calls == ["follow", "follow", "from rest"]
    assert not run.wants_timer


def test_a_heavy_mesh_slows_itself() -> None:
    """A step of a second is followed by a second without any; the timer then does what was left."""
    scene, run = begun()
    scene.step_s = 1.0
    scene.place = 1.0
    run.scene_changed(When.UPDATE)
    scene.now += 0.5
    scene.place = 2.0
    run.scene_changed(When.UPDATE)
    run.tick(is_playing=False)
    assert (scene.calls, run.wants_timer) == (["follow"], True)
    scene.now += 0.6
    run.tick(is_playing=False)
    assert (scene.calls, run.wants_timer) == (["follow", "follow"], False)


def test_a_light_mesh_follows_every_evaluation() -> None:
    scene, run = begun()
    scene.step_s = 0.9 * HEAVY_STEP_S
    for place in (1.0, 2.0, 3.0):
        scene.place = place
        run.scene_changed(When.UPDATE)
    assert scene.calls == ["follow"] * 3
    assert scene.limits[1:] == [(None, FOLLOW_TIME_LIMIT_S)] * 3


def test_a_frame_that_a_heavy_mesh_missed_still_starts_from_rest() -> None:
    scene, run = begun()
    scene.step_s = 1.0
    for place in (1.0, 2.0):
        scene.place = place
        run.scene_changed(When.SCRUB)
    scene.now += 2.0
    run.tick(is_playing=False)
    assert scene.calls == ["from rest", "from rest"]


def test_a_pause_ends_with_a_look_at_everything() -> None:
    scene, run = begun()
    scene.pause, scene.place = "Paused in Edit Mode", 1.0
    run.scene_changed(When.UPDATE)
    assert (run.pause, run.wants_timer, scene.calls) == ("Paused in Edit Mode", True, ["look again"])
    scene.pause = ""
    run.tick(is_playing=False)
    assert (run.pause, scene.calls) == ("", ["look again", "go on", "follow"])
    assert not run.wants_timer


def test_binds_by_the_timer_and_never_in_a_handler() -> None:
    scene, run = begin(is_fit=False)
    run.scene_changed(When.UPDATE)
    assert scene.binds == []
    run.tick(is_playing=False)
    run.tick(is_playing=True)
    assert (run.is_binding, run.bind_fraction, scene.binds[0].n_steps) == (True, 0.5, 1)
    scene.binds[0].is_done = True
    run.tick(is_playing=False)
    run.tick(is_playing=False)
    assert (run.is_binding, scene.calls) == (False, ["go on", "follow"])


def test_without_a_window_all_is_done_at_once() -> None:
    scene, run = begun()
    scene.place = 1.0
    run.settle(60.0)
    assert (scene.calls, scene.limits[-1]) == (["from rest"], (None, None))


def test_a_mesh_that_never_fits_ends_instead_of_binding_for_ever() -> None:
    scene = FakeScene(is_fit=False)

    plain = scene.begin_bind

    def begin_bind() -> FakeBind:
        bind = plain()
        bind.is_done = True
        bind.adopt = lambda: None  # type: ignore[method-assign]
        return bind

    scene.begin_bind = begin_bind  # type: ignore[method-assign]
    run = FollowRun(scene, scene.clock)
    run.settle(60.0)
    assert scene.off == ["The mesh changes each time it has been prepared"]
    assert run.is_over


def test_an_error_ends_it_once() -> None:
    scene, run = begun()
    scene.place, scene.error = 1.0, ZeroDivisionError("a fault of ours")
    for _ in range(3):
        run.scene_changed(When.UPDATE)
        run.tick(is_playing=False)
    assert (scene.off, run.is_over, run.wants_timer) == (["a fault of ours"], True, False)


def test_the_end_drops_a_bind() -> None:
    scene, run = begin(is_fit=False)
    run.tick(is_playing=False)
    run.end()
    assert scene.binds[0].is_dropped


def test_undo_looks_at_everything_and_goes_on_from_what_it_brought() -> None:
    scene, run = begun()
    run.undone()
    assert run.wants_timer
    run.tick(is_playing=False)
    assert scene.calls == ["undone", "go on", "follow"]


def test_an_undo_that_brings_the_same_pose_moves_nothing() -> None:
    """As one in another scene."""
    scene, run = begun()
    scene.is_shown = True
    run.undone()
    run.tick(is_playing=False)
    assert (scene.calls, run.wants_timer) == (["undone", "go on"], False)


def test_after_an_undo_to_no_pose_it_waits_until_something_moves() -> None:
    scene, run = begun()
    scene.has_pose = False
    run.undone()
    run.scene_changed(When.UPDATE)
    assert (scene.calls, run.wants_timer) == (["undone"], False)
    scene.place = 1.0
    run.scene_changed(When.UPDATE)
    assert scene.calls == ["undone", "go on", "follow"]


def test_evaluation_within_a_step_does_not_start_another() -> None:
    scene, run = begun()
    evaluate_with_matrices(scene, lambda: run.scene_changed(When.UPDATE))
    scene.place = 1.0
    run.tick(is_playing=False)
    assert scene.calls == ["follow"]


def test_a_stroke_is_waited_for_and_then_all_is_looked_at():
    scene, run = begun(needed_updates=1)
    scene.is_painted, scene.is_fit = True, False
    run.scene_changed(When.UPDATE)
    assert run.wants_timer
    for _ in range(3):
        run.tick(is_playing=False)
    assert not scene.binds
    assert not scene.calls
    scene.is_painted = False
    run.tick(is_playing=False)
    assert len(scene.binds) == 1


def test_a_bind_that_is_under_way_when_a_stroke_begins_is_still_taken():
    scene, run = begin(is_fit=False)
    run.tick(is_playing=False)
    scene.is_painted = True
    scene.binds[0].is_done = True
    run.tick(is_playing=False)
    assert scene.is_fit
    run.tick(is_playing=False)
    assert not scene.calls
    scene.is_painted = False
    run.tick(is_playing=False)
    assert scene.calls == ["go on", "follow"]


def test_what_cannot_be_for_now_pauses_and_does_not_switch_off():
    scene, run = begin(error=NotNow("Paused: nothing is painted yet"))
    run.tick(is_playing=False)
    assert (run.pause, scene.off, run.is_over) == ("Paused: nothing is painted yet", [], False)
    assert run.wants_timer
    scene.error = None
    run.tick(is_playing=False)
    assert (run.pause, scene.calls[-1]) == ("", "follow")


def test_the_scene_hears_when_all_is_settled():
    scene, run = begin(needed_updates=2)
    run.tick(is_playing=False)
    assert scene.n_settled == 0
    run.tick(is_playing=False)
    assert scene.n_settled == 1
