# SPDX-License-Identifier: GPL-3.0-or-later
"""The posing act without Blender: a fake scene stands for it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest
from arap_deform.core.tracker import FOLLOW_TIME_LIMIT_S, REFINE_TIME_LIMIT_S
from arap_deform.engine.interaction import KEEP_TIME_LIMIT_S, End, Ending, Interaction, Phase, restored, status_text
from fake_engine import FakeBind, FakeEngineScene, evaluate_with_matrices


@dataclass
class FakeScene(FakeEngineScene):
    """The scene of an act."""

    reason: str = ""
    needed_updates: int = 3

    def look(self) -> str:
        return self.reason

    def begin_bind(self) -> FakeBind:
        if self.error is not None:
            raise self.error
        return super().begin_bind()


def begin(**scene_options: Any) -> tuple[FakeScene, Interaction]:
    scene = FakeScene(**scene_options)
    act = Interaction(scene)
    act.begin()
    return scene, act


def begun(**scene_options: Any) -> tuple[FakeScene, Interaction]:
    """An act that has followed once."""
    scene, act = begin(**scene_options)
    act.tick()
    scene.calls.clear()
    return scene, act


def binding_again() -> tuple[FakeScene, Interaction]:
    """An act that has followed once and then binds, because groups have changed."""
    scene, act = begun()
    scene.is_fit = False
    act.tick()
    assert act.phase is Phase.BINDING
    return scene, act


def bind_and_follow(scene: FakeScene, act: Interaction) -> None:
    scene.binds[0].is_done = True
    act.tick()
    act.tick()


def how(act: Interaction) -> Ending | None:
    """How the act has ended, None if it has not."""
    return act.end.how if act.end is not None else None


def test_refines_until_settled_and_then_rests() -> None:
    scene, act = begun()
    assert not act.is_settled
    for _ in range(5):
        act.tick()
    assert scene.calls == ["refine", "refine"]
    assert act.is_settled


def test_a_moved_handle_is_followed_at_once_and_refined_later() -> None:
    scene, act = begun()
    scene.place = 1.0
    scene.needed_updates = 2
    act.scene_changed()
    act.scene_changed()
    assert scene.calls == ["follow"]
    act.tick()
    assert scene.calls == ["follow", "refine"]
    assert act.is_settled


def test_refining_ends_at_the_iteration_limit() -> None:
    scene, act = begun(needed_updates=1000, limit=12)
    for _ in range(10):
        act.tick()
    assert scene.calls == ["refine", "refine"]  # 4 iterations each, and 4 in the first update
    assert act.is_settled
    # Following takes the setting within a frame, and refining all that is left.
    assert scene.limits == [(None, FOLLOW_TIME_LIMIT_S), (8, REFINE_TIME_LIMIT_S), (4, REFINE_TIME_LIMIT_S)]


def test_a_session_that_fits_goes_on_from_the_pose_shown() -> None:
    scene, act = begin()
    assert act.phase is Phase.FOLLOWING
    assert scene.calls == ["go on"]


def test_binds_first_if_the_session_does_not_fit() -> None:
    scene, act = begin(is_fit=False)
    assert act.phase is Phase.BINDING
    act.tick()
    assert scene.binds[0].n_steps == 1
    act.scene_changed()
    assert scene.calls == []
    assert act.bind_fraction == 0.5
    bind_and_follow(scene, act)
    assert act.phase is Phase.FOLLOWING
    assert scene.calls == ["follow"]


def test_begin_raises_if_the_scene_cannot_be_posed() -> None:
    with pytest.raises(ValueError, match="no handles"):
        begin(is_fit=False, error=ValueError("no handles"))


@pytest.mark.parametrize("end", ["keep", "cancel"])
def test_ending_while_binding_drops_the_bind_and_restores(end: str) -> None:
    scene, act = begin(is_fit=False)
    getattr(act, end)()
    assert scene.binds[0].is_dropped
    assert how(act) is Ending.RESTORE


def test_a_failed_bind_restores_and_says_why() -> None:
    scene, act = begin(is_fit=False)
    scene.binds[0].error = ValueError("vertex 7 is not finite")
    bind_and_follow(scene, act)
    assert act.end is not None
    assert act.end.how is Ending.RESTORE
    assert "vertex 7 is not finite" in act.end.message


def test_changed_groups_bind_again_and_the_pose_goes_on() -> None:
    scene, act = binding_again()
    act.scene_changed()
    assert scene.calls == []
    bind_and_follow(scene, act)
    assert scene.calls == ["follow"]
    assert act.end is None


def test_keep_while_binding_again_waits_for_it() -> None:
    scene, act = binding_again()
    assert not act.is_keeping
    act.keep()
    assert act.is_keeping
    assert "keeping the pose" in status_text(act)
    assert act.end is None
    bind_and_follow(scene, act)
    assert scene.calls == ["follow", "refine"]
    assert how(act) is Ending.KEEP
    assert not scene.binds[0].is_dropped


@pytest.mark.parametrize(("ask", "ending"), [("keep", Ending.KEEP), ("cancel", Ending.RESTORE)])
def test_while_keep_waits_another_end_does_not_wait(ask: str, ending: Ending) -> None:
    scene, act = binding_again()
    act.keep()
    getattr(act, ask)()
    assert not act.is_keeping
    assert how(act) is ending
    assert scene.binds[0].is_dropped


@pytest.mark.parametrize("is_keeping", [True, False])
def test_an_act_without_ticks_keeps_the_pose_only_if_keep_was_called(is_keeping: bool) -> None:
    _, act = binding_again()
    if is_keeping:
        act.keep()
    act.end_now("over")
    assert act.end == (End(Ending.KEEP) if is_keeping else End(Ending.RESTORE, "over"))


def test_keep_waits_for_the_end_of_a_stroke() -> None:
    scene, act = begun(needed_updates=1)
    scene.is_painted = True
    act.keep()
    act.tick()
    assert act.end is None
    scene.is_painted, scene.place = False, 1.0
    act.tick()
    assert scene.calls == ["follow"]
    assert how(act) is Ending.KEEP


def test_keep_sees_what_only_following_has_shown() -> None:
    """The evaluation that a step causes tells of a stroke which ended just before."""
    scene, act = begun()
    evaluate_with_matrices(scene, lambda: setattr(scene, "is_fit", False), times=1)
    act.keep()
    assert act.end is None
    act.tick()
    bind_and_follow(scene, act)
    assert how(act) is Ending.KEEP


def test_what_cannot_be_bound_again_leaves_the_pose() -> None:
    scene, act = begun()
    scene.is_fit = False
    scene.error = ValueError("Nothing holds or moves 'Bar'")
    act.tick()
    assert act.end is not None
    assert act.end.how is Ending.LEAVE
    assert act.end.message.startswith("Nothing holds or moves 'Bar'")


def test_keep_follows_a_last_time_and_settles() -> None:
    scene, act = begun()
    scene.place = 1.0
    act.keep()
    assert scene.calls == ["follow", "refine"]
    assert scene.limits[-1] == (scene.limit - 4, KEEP_TIME_LIMIT_S)
    assert how(act) is Ending.KEEP


@pytest.mark.parametrize(("needed_updates", "is_settling"), [(1, True), (50, False)])
def test_keep_does_nothing_more_if_all_is_settled_or_need_not_be(needed_updates: int, is_settling: bool) -> None:
    scene, act = begun(needed_updates=needed_updates)
    act.keep(is_settling=is_settling)
    assert scene.calls == []
    assert how(act) is Ending.KEEP


def test_a_scene_that_is_over_ends_without_a_touch() -> None:
    scene, act = begun()
    scene.place = 1.0
    scene.reason = "'Bar' is no longer there"
    act.scene_changed()
    act.keep()
    act.tick()
    assert scene.calls == []
    assert act.end == End(Ending.LEAVE, scene.reason)


def test_an_exception_restores_and_is_told() -> None:
    scene, act = begun()
    scene.place = 1.0
    scene.error = ZeroDivisionError("a fault of ours")
    act.scene_changed()
    assert act.end is not None
    assert act.end.how is Ending.RESTORE
    assert act.end.error is scene.error
    assert "a fault of ours" in act.end.message


def test_the_first_end_counts() -> None:
    _, act = begun()
    act.cancel("first")
    act.keep()
    act.leave("later")
    assert act.end == End(Ending.RESTORE, "first")
    assert act.phase is Phase.ENDED


def test_undo_goes_on_from_what_it_brought() -> None:
    scene, act = begun(needed_updates=1)
    act.undone()
    act.tick()
    assert scene.calls == ["go on", "follow"]


def test_evaluation_within_a_step_does_not_start_another() -> None:
    scene, act = begun()
    evaluate_with_matrices(scene, act.scene_changed)
    scene.place = 1.0
    act.tick()
    assert scene.calls == ["follow"]


def test_status_says_state_and_keys() -> None:
    _, act = begin(is_fit=False)
    assert "preparing the mesh, 50%" in status_text(act)
    assert "Esc: cancel" in status_text(act)
    _, act = begun(needed_updates=1)
    assert "settled" in status_text(act)
    for key in ("G, R, S", "Ctrl Z", "Enter: keep", "Esc: cancel"):
        assert key in status_text(act)


def test_unsettled_until_a_step_has_looked() -> None:
    scene, act = begun(needed_updates=1)
    assert act.is_settled
    act.unsettle()
    assert not act.is_settled
    act.tick()
    assert scene.calls == ["refine"]
    assert act.is_settled


def test_what_cannot_be_restored_is_said() -> None:
    def refuse() -> None:
        raise ValueError("the shape key stays")

    end = End(Ending.RESTORE, "Gone")
    assert restored(end, lambda: None) is end
    told = restored(end, refuse)
    assert told.message == "Gone the shape key stays"
    assert isinstance(told.error, ValueError)
    former = RuntimeError("first")
    assert restored(End(Ending.RESTORE, "", former), refuse).error is former


def test_a_stroke_is_waited_for_and_then_the_mesh_is_bound_again() -> None:
    scene, act = begun()
    scene.is_painted, scene.is_fit = True, False
    act.scene_changed()
    act.tick()
    assert not scene.binds
    scene.is_painted = False
    act.tick()
    assert len(scene.binds) == 1
    assert act.phase is Phase.BINDING
