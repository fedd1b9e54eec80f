# SPDX-License-Identifier: GPL-3.0-or-later
"""The interaction as a state machine. EngineScene stands for Blender; tests fake it.

    BINDING --bound--> FOLLOWING --end--> ENDED
       ^                   |
       +----out of date----+

``end`` says how and why the interaction has ended. After that nothing here touches the scene.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum, auto

from ..core import native
from ..core.tracker import FOLLOW_TIME_LIMIT_S, REFINE_TIME_LIMIT_S, BindProgress, EngineScene, HandleTracker

# Keep settles the pose first, but not for longer than an artist waits for Enter.
KEEP_TIME_LIMIT_S = 2.0


class Phase(Enum):
    BINDING = auto()
    FOLLOWING = auto()
    ENDED = auto()


class Ending(Enum):
    KEEP = auto()  # the pose stays
    RESTORE = auto()  # key, slider and handles as they were before the interaction
    LEAVE = auto()  # the scene stays as it is: the posed mesh has gone or changed


@dataclass(frozen=True)
class End:
    """How an interaction ended. ``message`` is for the user, '' if there is nothing to say."""

    how: Ending
    message: str = ""
    error: Exception | None = None


class Interaction(BindProgress):
    """One interaction of one object, from begin() until ``end`` is set.

    A timer calls tick(). scene_changed() is called after each evaluation of the scene, undone() after an undo or redo.
    cancel(), leave() and fail() end it; keep() ends it now or in a later tick(). None of them raises. If the scene
    raises ValueError once there is a pose, the pose stays; any other exception restores everything.
    """

    def __init__(self, scene: EngineScene, *, is_drag: bool = False) -> None:
        """Prepares it. ``is_drag``: it lasts for one drag, so panels offer nothing meanwhile."""
        self._scene = scene
        self.is_drag = is_drag
        self._tracker = HandleTracker(scene)
        self._is_busy = False
        self._is_keeping = False
        self.end: End | None = None

    @property
    def doing(self) -> str:
        """What Follow waits for, and what a refused call says."""
        return "it is pulled" if self.is_drag else "it is posed"

    @property
    def phase(self) -> Phase:
        if self.end is not None:
            return Phase.ENDED
        return Phase.BINDING if self._tracker.is_binding else Phase.FOLLOWING

    @property
    def is_keeping(self) -> bool:
        """Whether keep() was called and the interaction ends when the mesh has followed."""
        return self._is_keeping and self.end is None

    @property
    def is_settled(self) -> bool:
        return self._tracker.is_settled

    def begin(self) -> None:
        """Binds if the session does not fit. Raises ValueError if the scene cannot be posed: nothing has begun."""
        self._tracker.begin()

    def tick(self, refine_time_s: float = REFINE_TIME_LIMIT_S) -> None:
        """A step of binding, following or refining. Nothing if the mesh has settled."""
        self._guarded(lambda: self._tick(refine_time_s))

    def scene_changed(self) -> None:
        """Follows the handles if they have moved."""
        if not self._tracker.is_binding:
            self._guarded(self._follow_if_ready)

    def unsettle(self) -> None:
        """The scene wants another pose, even if no step has seen that yet."""
        self._tracker.is_settled = False

    def undone(self) -> None:
        """Goes on from the pose that undo or redo has brought. The next step follows the handles."""
        self._guarded(self._tracker.go_on_from_shown)

    def keep(self, *, is_settling: bool = True) -> None:
        """Settles the pose and ends the interaction with it. If there is no pose yet, everything is restored.

        If the mesh must be bound again first, as after a stroke of weights, a later tick() ends it. A second call does
        not wait for that.
        """
        if not self._tracker.has_followed:
            self.cancel()
        elif is_settling and not self._is_keeping:
            self._is_keeping = True
            self._guarded(self._keep_once_settled)
        else:
            self._finish(End(Ending.KEEP))

    def end_now(self, message: str = "") -> None:
        """For when tick() is called no more: ends with the pose if keep() was called, else as cancel()."""
        if self._is_keeping:
            self._finish(End(Ending.KEEP))
        else:
            self.cancel(message)

    def cancel(self, message: str = "") -> None:
        self._finish(End(Ending.RESTORE, message))

    def leave(self, message: str) -> None:
        self._finish(End(Ending.LEAVE, message))

    def fail(self, error: Exception) -> None:
        text = native.sentence_of(error)
        self._finish(End(Ending.RESTORE, f"Posing has ended and everything is as before: {text}", error))

    def _guarded(self, step: Callable[[], object]) -> None:
        # Reading evaluated matrices evaluates the scene, which calls scene_changed() within tick().
        if self.end is not None or self._is_busy:
            return
        self._is_busy = True
        try:
            reason = self._scene.look()
            if reason:
                self.leave(reason)
            else:
                step()
        except ValueError as error:  # the scene is at fault: say so and keep the artist's work
            if self._tracker.has_followed:
                self.leave(f"{error}. The pose is kept and posing has ended")
            else:
                self.fail(error)
        except Exception as error:  # noqa: BLE001 - whatever it is, the artist's mesh and handles come first
            self.fail(error)
        finally:
            self._is_busy = False

    def _tick(self, refine_time_s: float) -> None:
        if not self._tracker.prepare():
            return
        if self._is_keeping:
            self._keep_once_settled()
        elif not self._tracker.follow(FOLLOW_TIME_LIMIT_S):
            self._tracker.refine(refine_time_s)

    def _follow_if_ready(self) -> None:
        if self._tracker.is_ready():
            self._tracker.follow(FOLLOW_TIME_LIMIT_S)

    def _keep_once_settled(self) -> None:
        if self._tracker.is_ready():
            self._tracker.follow(FOLLOW_TIME_LIMIT_S)
            self._tracker.refine(KEEP_TIME_LIMIT_S)
            # Looking evaluates the scene, and that may tell of a stroke that has just ended.
            if not self._scene.look() and self._tracker.is_ready():
                self._finish(End(Ending.KEEP))

    def _finish(self, end: End) -> None:
        if self.end is not None:
            return
        self._tracker.drop()
        self.end = end


def restored(end: End, restore: Callable[[], object]) -> End:
    """Calls ``restore`` and returns the end. If restoring fails, the end also says why."""
    try:
        restore()
    except Exception as error:  # noqa: BLE001 - whatever it is, the interaction ends; print_fault() shows a fault of ours
        return replace(end, message=f"{end.message} {error}".strip(), error=end.error or error)
    return end


def print_fault(error: Exception | None) -> None:
    """Prints the traceback of a fault in the add-on: a report on it needs more than a sentence."""
    if error is not None and not isinstance(error, native.ERRORS):
        traceback.print_exception(error)


def status_text(interaction: Interaction) -> str:
    """What the status bar says: state, then keys."""
    if interaction.is_keeping:
        text = "ARAP Pose: keeping the pose, preparing the mesh, {:.0%}   |   Enter: at once   |   Esc: cancel"
        return text.format(interaction.bind_fraction)
    if interaction.phase is Phase.BINDING:
        return f"ARAP Pose: preparing the mesh, {interaction.bind_fraction:.0%}   |   Esc: cancel"
    text = (
        "ARAP Pose: {}   |   G, R, S: move, turn, scale a handle   |   Ctrl Z: take a move back"
        "   |   Enter: keep   |   Esc: cancel"
    )
    return text.format("settled" if interaction.is_settled else "following")
