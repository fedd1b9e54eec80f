# SPDX-License-Identifier: GPL-3.0-or-later
"""Dragging the factor of a blend of poses: the handles go with the mouse, and the mesh comes after them."""

from __future__ import annotations

from collections.abc import Callable

import bpy

from ..core import sessions
from ..core.following import FOLLOW_TIME_LIMIT_S, Follower
from ..follow.scene import BlenderFollowScene
from ..pose.result import capture_state, restore_state, restore_transforms
from ..props import preferences
from ..scene import redraw
from ..ui.checks import StatusBar
from .library import Placement

TIMER_S = 0.02
PIXELS_A_BLEND = 300  # that the mouse goes from one pose to the other, at a display of usual resolution


class BlendRun:
    """From the button until it is kept or taken back. Names instead of references, and one exit."""

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
        """Begins. Raises ValueError where the mesh cannot be posed; then nothing has changed.

        Args:
            context: of the window.
            obj: the mesh.
            blend: moves the handles, from where they are, by a factor.
            mouse_x: where the mouse is, in pixels: factor 0.
            is_followed: something else lets the mesh follow its handles.
        """
        self._name = obj.name
        self._blend = blend
        self._start_x = mouse_x
        self._pixels = PIXELS_A_BLEND * context.preferences.system.ui_scale
        self._state = capture_state(obj)
        self._follower = None if is_followed else Follower(BlenderFollowScene(obj))
        if self._follower is not None:
            self._follower.begin()
            sessions.claim(obj.name, self)
        self._status = StatusBar()
        self._timer = context.window_manager.event_timer_add(TIMER_S, window=context.window)
        _runs.append(self)

    def show_status(self, context: bpy.types.Context, text: str) -> None:
        self._status.show(context, text)

    @property
    def is_ready(self) -> bool:
        """Whether the mesh is prepared."""
        return self._follower is None or not self._follower.is_binding

    @property
    def bind_fraction(self) -> float:
        return 1.0 if self._follower is None else self._follower.bind_fraction

    def factor_at(self, mouse_x: int) -> float:
        """0 to 1."""
        return float(min(max((mouse_x - self._start_x) / self._pixels, 0.0), 1.0))

    def set_factor(self, factor: float) -> None:
        """Moves the handles. Raises as the blend."""
        restore_transforms(self._state.transforms)  # it may begin where they are
        self._blend(self._object(), factor)

    def tick(self) -> bool:
        """A step of binding, following or refining; True where the mesh has moved. Raises what the scene raises."""
        follower = self._follower
        if follower is None or not follower.prepare():
            return False
        if follower.follow(FOLLOW_TIME_LIMIT_S):
            return True
        if follower.is_settled:
            return False
        follower.refine(preferences.refine_time_s())
        return True

    def end(self) -> None:
        """Gives window and mesh free; handles and mesh stay as they are. Again, it does nothing."""
        if self not in _runs:
            return
        _runs.remove(self)
        bpy.context.window_manager.event_timer_remove(self._timer)
        if self._follower is not None:
            self._follower.drop()
            sessions.release(self._name, self)
        self._status.clear()
        redraw.tag_panels()

    def cancel(self) -> str:
        """Ends it, and everything is as before; see restore()."""
        self.end()
        return self.restore()

    def restore(self) -> str:
        """Everything as it was at the start, where it is still there; what could not be, and why, '' where all could.

        No ValueError or RuntimeError leaves it: it is what is left to do when something has gone wrong.
        """
        obj = bpy.data.objects.get((self._name, None))
        try:
            if obj is None or self._follower is None:
                restore_transforms(self._state.transforms)
            else:
                restore_state(obj, self._state)
        except (ValueError, RuntimeError) as error:
            return str(error)
        return ""

    def restore_handles(self) -> None:
        """The handles as they were at the start."""
        restore_transforms(self._state.transforms)

    def _object(self) -> bpy.types.Object:
        obj = bpy.data.objects.get((self._name, None))
        if obj is None:
            raise RuntimeError(f"'{self._name}' was deleted or renamed")
        return obj


_runs: list[BlendRun] = []


def cancel_all() -> None:
    """The add-on is disabled: Blender drops running operators without a word when their class goes."""
    for run in _runs.copy():
        run.cancel()
