# SPDX-License-Identifier: GPL-3.0-or-later
"""The posing act in a window: its timer, its status text, handlers that say when the scene was evaluated, one exit."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from ..core import sessions
from ..engine.act import End, Ending, Phase, PoseAct, print_fault, restored, status_text
from ..engine.scene import is_rendering
from ..follow.runs import give_up
from ..props import preferences
from ..scene import known, redraw, undo_step
from ..scene.registration import for_each
from ..ui import waiting
from ..ui.modal import ModalRun
from ..ui.waits import Wait, wait_for_bind
from . import undo
from .scene import ActScene, BlenderPoseScene

TIMER_S = 0.02


class ActRun(ModalRun):
    """An act that has begun, and its share of the window."""

    def __init__(self, context: bpy.types.Context, scene: ActScene, act: PoseAct, timer_s: float) -> None:
        obj = scene.obj
        assert obj is not None
        sessions.claim(obj, act)
        self.scene = scene
        self.act = act
        super().__init__(context, timer_s)

    def step(self) -> None:
        """A step of the act. A bind that lasts is shown in the views."""
        self.act.tick(preferences.refine_time_s())
        if self.act.phase is Phase.BINDING:
            waiting.watch(self)

    def wait(self) -> Wait | None:
        return wait_for_bind(self.scene.name, self.act)

    def finish(self) -> End:
        """The one exit of all ends; ``end.message`` is what is left to say."""
        end = self.act.end
        assert end is not None
        sessions.release(self.scene.uid, self.act)
        obj = self.scene.obj
        if obj is None:
            sessions.drop(self.scene.uid)
        elif end.how is Ending.RESTORE:
            end = restored(end, lambda: self.scene.restore(obj))
        self.leave()
        print_fault(end.error)
        return end

    def abort(self, message: str = "") -> None:
        self.act.end_now(message)
        self.finish()


class PoseRun(ActRun):
    """A run of Pose."""

    scene: BlenderPoseScene

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        """Begins the act. Raises ValueError or RuntimeError if it cannot; then nothing has changed."""
        sessions.check_free(obj)
        give_up(obj)
        scene = BlenderPoseScene(obj)
        act = PoseAct(scene)
        scene.act_number = undo.mark(obj)
        try:
            act.begin()
        except BaseException:
            obj.arap.pose_act = 0
            raise
        undo_step.push("Begin ARAP Pose")
        super().__init__(context, scene, act, TIMER_S)
        runs.append(self)

    def show_status(self, context: bpy.types.Context) -> None:
        self.show_text(context, status_text(self.act))

    def tick(self, context: bpy.types.Context) -> None:
        if is_rendering():
            return
        before = self.act.readout
        self.step()
        if self.act.phase is Phase.BINDING:
            self.show_status(context)
        if self.act.readout is not before or self.act.phase is Phase.BINDING:
            redraw.tag_panels()

    def finish(self) -> End:
        runs.remove(self)
        end = super().finish()
        undo.finish(self.scene.uid, self.scene.act_number, as_one_step=end.how is not Ending.LEAVE)
        return end


runs: list[PoseRun] = []


def scene_changed(
    scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph, updates: Sequence[known.Update] | None
) -> None:
    """After an evaluation. ``updates``: None for another frame."""
    if not runs or is_rendering():
        return

    def tell(run: PoseRun) -> None:
        if run.scene.obj is None or known.is_in(scene, run.scene.obj):
            with run.scene.evaluated(depsgraph, updates):
                run.act.scene_changed()

    for_each(runs.copy(), tell)


def undone() -> None:
    """After an undo."""
    for_each(runs.copy(), _undone)


def _undone(run: PoseRun) -> None:
    if run.scene.obj is None:
        run.act.leave("Undo went back to before this pose: posing has ended")
    else:
        run.scene.key.forget_address()
        run.act.undone()
