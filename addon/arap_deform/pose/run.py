# SPDX-License-Identifier: GPL-3.0-or-later
"""The interaction in a window: its timer, its status text, handlers that say when the scene was evaluated, one exit."""

from __future__ import annotations

from collections.abc import Sequence

import bpy

from ..core import sessions
from ..engine.interaction import End, Ending, Interaction, Phase, print_fault, restored, status_text
from ..engine.scene import is_rendering
from ..follow.runs import clear_follow_error
from ..props import preferences
from ..scene import known, redraw, undo_step
from ..scene.registration import for_each
from ..ui import waiting
from ..ui.modal import ModalRun
from ..ui.waits import Wait, wait_for_bind
from . import undo
from .scene import BlenderPoseScene, InteractionScene

TIMER_S = 0.02


class InteractionRun(ModalRun):
    """An interaction that has begun, and its share of the window."""

    def __init__(
        self, context: bpy.types.Context, scene: InteractionScene, interaction: Interaction, timer_s: float
    ) -> None:
        obj = scene.obj
        assert obj is not None
        sessions.lock(obj, interaction)
        self.scene = scene
        self.interaction = interaction
        super().__init__(context, timer_s)

    def step(self) -> None:
        """A step of the interaction. A bind that lasts is shown in the views."""
        self.interaction.tick(preferences.refine_time_s())
        if self.interaction.phase is Phase.BINDING:
            waiting.watch(self)

    def wait(self) -> Wait | None:
        return wait_for_bind(self.scene.name, self.interaction)

    def finish(self) -> End:
        """The one exit of all ends; ``end.message`` is what is left to say."""
        end = self.interaction.end
        assert end is not None
        sessions.unlock(self.scene.uid, self.interaction)
        obj = self.scene.obj
        if obj is None:
            sessions.drop(self.scene.uid)
        elif end.how is Ending.RESTORE:
            end = restored(end, lambda: self.scene.restore(obj))
        self.leave()
        print_fault(end.error)
        return end

    def abort(self, message: str = "") -> None:
        self.interaction.end_now(message)
        self.finish()


class PoseRun(InteractionRun):
    """A run of Pose."""

    scene: BlenderPoseScene

    def __init__(self, context: bpy.types.Context, obj: bpy.types.Object) -> None:
        """Begins the interaction. Raises ValueError or RuntimeError if it cannot; then nothing has changed."""
        sessions.check_free(obj)
        clear_follow_error(obj)
        scene = BlenderPoseScene(obj)
        interaction = Interaction(scene)
        scene.act_number = undo.mark(obj)
        try:
            interaction.begin()
        except BaseException:
            obj.arap.interaction_number = 0
            raise
        undo_step.push("Begin ARAP Pose")
        super().__init__(context, scene, interaction, TIMER_S)
        runs.append(self)

    def show_status(self, context: bpy.types.Context) -> None:
        self.show_text(context, status_text(self.interaction))

    def tick(self, context: bpy.types.Context) -> None:
        if is_rendering():
            return
        before = self.interaction.stats
        self.step()
        if self.interaction.phase is Phase.BINDING:
            self.show_status(context)
        if self.interaction.stats is not before or self.interaction.phase is Phase.BINDING:
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
                run.interaction.scene_changed()

    for_each(runs.copy(), tell)


def undone() -> None:
    """After an undo."""
    for_each(runs.copy(), _undone)


def _undone(run: PoseRun) -> None:
    if run.scene.obj is None:
        run.interaction.leave("Undo went back to before this pose: posing has ended")
    else:
        run.scene.key.forget_address()
        run.interaction.undone()
