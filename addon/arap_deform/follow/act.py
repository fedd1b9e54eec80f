# SPDX-License-Identifier: GPL-3.0-or-later
"""The posing act as a state machine. No bpy: what it needs of Blender comes through PoseScene, tests fake it.

    BINDING --bound--> FOLLOWING --end--> ENDED
       ^                   |
       +----out of date----+

However the act ends, ``end`` says how and why, once; after that nothing in here touches the scene any more.
"""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum, auto
from typing import Protocol

from ..core.following import FOLLOW_TIME_LIMIT_S, REFINE_TIME_LIMIT_S, Follower, FollowScene
from ..core.session_data import Readout

# What is kept is settled, where that takes no longer than somebody waits for Enter.
KEEP_TIME_LIMIT_S = 2.0


class Phase(Enum):
    BINDING = auto()
    FOLLOWING = auto()
    ENDED = auto()


class Ending(Enum):
    KEEP = auto()  # the pose stays
    RESTORE = auto()  # key, slider and handles as they were before the act
    LEAVE = auto()  # the scene is left as it is: what the act posed has gone or changed


@dataclass(frozen=True)
class End:
    """How an act ended. ``message`` is for the user, '' where there is nothing to say."""

    how: Ending
    message: str = ""
    error: Exception | None = None


class PoseScene(FollowScene, Protocol):
    """What the act needs of Blender, for one object."""

    def why_over(self) -> str:
        """Why the act cannot go on (object gone, other mode, other mesh ...), one sentence; '' while it can."""


class PoseAct:
    """One posing act of one object, from begin() until ``end`` is set.

    tick() is called by a timer, scene_changed() after each evaluation of the scene, undone() after an undo or redo;
    cancel(), leave() and fail() end the act, keep() does so now or in a later tick(). None of them raises. A ValueError
    of the scene once there is a pose leaves it as it is; any other exception restores everything.
    """

    def __init__(self, scene: PoseScene, *, is_drag: bool = False) -> None:
        """Prepares it; ``is_drag``: it lasts for one drag, so panels have nothing to offer meanwhile."""
        self._scene = scene
        self.is_drag = is_drag
        self._follower = Follower(scene)
        self._is_busy = False
        self._is_keeping = False
        self.end: End | None = None

    @property
    def doing(self) -> str:
        """For Live, which waits, and for those who ask in vain."""
        return "it is pulled" if self.is_drag else "it is posed"

    @property
    def phase(self) -> Phase:
        if self.end is not None:
            return Phase.ENDED
        return Phase.BINDING if self._follower.is_binding else Phase.FOLLOWING

    @property
    def is_keeping(self) -> bool:
        """Whether it ends by itself as soon as the mesh has followed."""
        return self._is_keeping and self.end is None

    @property
    def bind_fraction(self) -> float:
        return self._follower.bind_fraction

    @property
    def readout(self) -> Readout | None:
        return self._follower.readout

    @property
    def is_settled(self) -> bool:
        return self._follower.is_settled

    def begin(self) -> None:
        """Binds where that is needed. Raises ValueError where the scene cannot be posed: then no act has begun."""
        self._follower.begin()

    def tick(self, refine_time_s: float = REFINE_TIME_LIMIT_S) -> None:
        """Goes on binding, or follows and refines; nothing where all is settled."""
        self._guarded(lambda: self._tick(refine_time_s))

    def scene_changed(self) -> None:
        """Follows the handles where they moved."""
        if not self._follower.is_binding:
            self._guarded(self._follow_if_ready)

    def unsettle(self) -> None:
        """The scene wants something else from here on, even where no step has looked yet."""
        self._follower.is_settled = False

    def undone(self) -> None:
        """Goes on from what undo or redo has brought; the next step follows the handles anew."""
        self._guarded(self._follower.go_on_from_shown)

    def keep(self, *, is_settling: bool = True) -> None:
        """Ends the act with the pose, settled first; where there is none yet, everything is restored.

        A mesh that has to be bound again first, as after a stroke of weights, is waited for: a later tick() ends it.
        Asked again, it does not wait.
        """
        if not self._follower.has_followed:
            self.cancel()
        elif is_settling and not self._is_keeping:
            self._is_keeping = True
            self._guarded(self._keep_once_settled)
        else:
            self._finish(End(Ending.KEEP))

    def end_now(self, message: str = "") -> None:
        """Nobody will call tick() again: ends with the pose where keep() was asked for, else as cancel()."""
        if self._is_keeping:
            self._finish(End(Ending.KEEP))
        else:
            self.cancel(message)

    def cancel(self, message: str = "") -> None:
        self._finish(End(Ending.RESTORE, message))

    def leave(self, message: str) -> None:
        self._finish(End(Ending.LEAVE, message))

    def fail(self, error: Exception) -> None:
        self._finish(End(Ending.RESTORE, f"Posing has ended and everything is as before: {error}", error))

    def _guarded(self, step: Callable[[], object]) -> None:
        # Reading evaluated matrices evaluates the scene, which calls scene_changed() within tick().
        if self.end is not None or self._is_busy:
            return
        self._is_busy = True
        try:
            reason = self._scene.why_over()
            if reason:
                self.leave(reason)
            else:
                step()
        except ValueError as error:  # the scene is at fault: say so, and do not throw the artist's work away
            if self._follower.has_followed:
                self.leave(f"{error}. The pose is kept and posing has ended")
            else:
                self.fail(error)
        except Exception as error:  # noqa: BLE001 - whatever it is, the artist's mesh and handles come first
            self.fail(error)
        finally:
            self._is_busy = False

    def _tick(self, refine_time_s: float) -> None:
        if not self._follower.prepare():
            return
        if self._is_keeping:
            self._keep_once_settled()
        elif not self._follower.follow(FOLLOW_TIME_LIMIT_S):
            self._follower.refine(refine_time_s)

    def _follow_if_ready(self) -> None:
        if self._follower.is_ready():
            self._follower.follow(FOLLOW_TIME_LIMIT_S)

    def _keep_once_settled(self) -> None:
        if self._follower.is_ready():
            self._follower.follow(FOLLOW_TIME_LIMIT_S)
            self._follower.refine(KEEP_TIME_LIMIT_S)
            # To look is to evaluate the scene, and only that may tell of a stroke that ended just now.
            if self._follower.is_ready():
                self._finish(End(Ending.KEEP))

    def _finish(self, end: End) -> None:
        if self.end is not None:
            return
        self._follower.drop()
        self.end = end


def restored(end: End, restore: Callable[[], object]) -> End:
    """Calls ``restore``; the end, which says too why that could not be done where it could not."""
    try:
        restore()
    except (ValueError, RuntimeError) as error:
        return replace(end, message=f"{end.message} {error}".strip(), error=end.error or error)
    return end


def print_fault(end: End) -> None:
    """Prints where a fault of ours comes from: the report on it needs more than a sentence."""
    if end.error is not None and not isinstance(end.error, (ValueError, RuntimeError)):
        traceback.print_exception(end.error)


def status_text(act: PoseAct) -> str:
    """What the status bar says: state, then keys."""
    if act.is_keeping:
        text = "ARAP Pose: keeping the pose, preparing the mesh, {:.0%}   |   Enter: at once   |   Esc: cancel"
        return text.format(act.bind_fraction)
    if act.phase is Phase.BINDING:
        return f"ARAP Pose: preparing the mesh, {act.bind_fraction:.0%}   |   Esc: cancel"
    text = (
        "ARAP Pose: {}   |   G, R, S: move, turn, scale a handle   |   Ctrl Z: take a move back"
        "   |   Enter: keep   |   Esc: cancel"
    )
    return text.format("settled" if act.is_settled else "following")
