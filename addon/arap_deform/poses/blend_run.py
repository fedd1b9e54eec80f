# SPDX-License-Identifier: GPL-3.0-or-later
"""Dragging the factor of a blend of poses: the handles follow the mouse, and the mesh follows the handles."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..core import native, sessions
from ..core.tracker import FOLLOW_TIME_LIMIT_S, HandleTracker
from ..engine import ready
from ..engine.scene import BlenderEngineScene
from ..pose.result import capture_state, restore_state, restore_transforms
from ..props import preferences
from ..scene import known
from ..ui import waiting
from ..ui.modal import ModalRun
from ..ui.waits import Wait, wait_for_bind
from .library import Placement

TIMER_S = 0.02
PIXELS_A_BLEND = 300  # from one pose to the other, at UI scale 1


class BlendRun(ModalRun):
    """One drag, until it is kept or cancelled. It holds no Blender data."""

    doing = "its poses are blended"

    def __init__(
        self,
        context: bpy.types.Context,
        obj: bpy.types.Object,
        blend: Callable[[bpy.types.Object, float], Placement],
        mouse_x: int,
        *,
        is_followed: bool,
    ) -> None:
        """Begins. Raises ValueError if the mesh cannot be posed; then nothing has changed.

        Args:
            context: of the window.
            blend: moves the handles by a factor, from their present places.
            mouse_x: pixel of the mouse at factor 0.
            is_followed: Pose or Follow keeps the mesh to its handles.
        """
        self._uid = known.add(obj)
        self._name = obj.name  # for messages
        self._blend = blend
        self._start_x = mouse_x
        self._pixels = PIXELS_A_BLEND * context.preferences.system.ui_scale
        if not is_followed:
            ready.check(obj, context.evaluated_depsgraph_get())
        self._state = capture_state(obj)
        self._scene = BlenderEngineScene(obj)
        self._tracker = None if is_followed else HandleTracker(self._scene)
        if self._tracker is not None:
            self._tracker.begin()
            sessions.lock(obj, self)
        super().__init__(context, TIMER_S)

    def wait(self) -> Wait | None:
        return None if self._tracker is None else wait_for_bind(self._name, self._tracker)

    def show_status(self, context: bpy.types.Context, text: str) -> None:
        if not self.is_ready and self._tracker is not None:
            text = f"preparing the mesh, {self._tracker.bind_fraction:.0%}   |   {text}"
        self.show_text(context, f"ARAP Blend: {text}")

    @property
    def is_ready(self) -> bool:
        """Whether the mesh is prepared."""
        return self._tracker is None or not self._tracker.is_binding

    def factor_at(self, mouse_x: int) -> float:
        """0 to 1."""
        return float(min(max((mouse_x - self._start_x) / self._pixels, 0.0), 1.0))

    def set_factor(self, factor: float) -> None:
        """Moves the handles. Raises as the blend."""
        self.restore_handles()  # the blend may begin at their places
        obj = known.find(self._uid)
        if obj is None:
            raise RuntimeError(f"'{self._name}' was deleted")
        self._blend(obj, factor)

    def tick(self) -> bool:
        """A step of binding, following or refining; True if the mesh has moved. Raises as the scene."""
        tracker = self._tracker
        if tracker is None:
            return False
        self._scene.look()
        if not tracker.prepare():
            waiting.watch(self)
            return False
        if tracker.follow(FOLLOW_TIME_LIMIT_S):
            return True
        if tracker.is_settled:
            return False
        tracker.refine(preferences.refine_time_s())
        return True

    def end(self) -> None:
        """Gives up window and mesh; handles and mesh stay. A second call does nothing."""
        if self.has_left:
            return
        if self._tracker is not None:
            self._tracker.drop()
            sessions.unlock(self._uid, self)
        self.leave()

    def abort(self, _message: str = "") -> str:
        """Ends it and puts everything back; see restore()."""
        self.end()
        return self.restore()

    def restore(self) -> str:
        """Puts everything back that still exists. Returns what could not be put back and why, else ''."""
        obj = known.find(self._uid)
        try:
            if obj is None or self._tracker is None:
                self.restore_handles()
            else:
                restore_state(obj, self._state)
        except native.ERRORS as error:
            return native.sentence_of(error)
        return ""

    def restore_handles(self) -> None:
        restore_transforms(self._state.transforms)
