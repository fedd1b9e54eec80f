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
from dataclasses import dataclass
from enum import Enum, auto
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..session import Readout

running: dict[str, PoseAct] = {}
"""The acts under way, by name of the object: for panels and polls."""

# What a solve may take while a handle moves: with all else of a frame about sixty frames a second. It is looked at
# after each iteration, so that a mesh too heavy for that still follows, with one.
FOLLOW_TIME_LIMIT_S = 0.012
# A refining step lets go of the window after this time, so that a heavy mesh does not make the mouse stutter.
REFINE_TIME_LIMIT_S = 0.05
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


class Bind(Protocol):
    """A bind in a worker thread, from start() on."""

    @property
    def fraction(self) -> float: ...
    @property
    def is_done(self) -> bool: ...
    def start(self) -> None:
        """Does nothing where it has started."""

    def drop(self) -> None: ...
    def adopt(self) -> None:
        """Makes the result the live session; raises what the bind raised. Only when done."""


class PoseScene(Protocol):
    """What the act needs of Blender, for one object."""

    def why_over(self) -> str:
        """Why the act cannot go on (object gone, other mode, other mesh ...), one sentence; '' while it can."""

    def is_bound(self) -> bool:
        """True while the live session fits the mesh, groups and settings."""

    def begin_bind(self) -> Bind:
        """Reads the scene for a bind in a worker thread. Raises ValueError where the scene cannot be posed."""

    def go_on_from_shown(self) -> None:
        """Starts the live session from the pose that the key shows now."""

    def matrices(self) -> NDArray[np.float64]:
        """(h, 4, 4) float64 object-space motions of the handles, evaluated."""

    def update(self, iterations: int | None, time_limit_s: float) -> Readout:
        """Solves for the handles where they are, and writes the key: at most so many iterations, None: the setting."""

    def iteration_limit(self) -> int:
        """Iterations at most for one place of the handles."""


class PoseAct:
    """One posing act of one object, from begin() until ``end`` is set.

    tick() is called by a timer, scene_changed() after each evaluation of the scene, undone() after an undo or redo;
    keep(), cancel(), leave() and fail() end the act. None of them raises. A ValueError of the scene once there is a
    pose leaves it as it is; any other exception restores everything.
    """

    def __init__(self, scene: PoseScene, *, is_drag: bool = False) -> None:
        """Prepares it; ``is_drag``: it lasts for one drag, so panels have nothing to offer meanwhile."""
        self._scene = scene
        self.is_drag = is_drag
        self._bind: Bind | None = None
        self._matrices: NDArray[np.float64] | None = None
        self._has_followed = False
        self._iterations_here = 0
        self._is_busy = False
        self.readout: Readout | None = None
        self.is_settled = False
        self.end: End | None = None

    @property
    def phase(self) -> Phase:
        if self.end is not None:
            return Phase.ENDED
        return Phase.BINDING if self._bind is not None else Phase.FOLLOWING

    @property
    def bind_fraction(self) -> float:
        return self._bind.fraction if self._bind is not None else 1.0

    def begin(self) -> None:
        """Binds where that is needed. Raises ValueError where the scene cannot be posed: then no act has begun."""
        if self._scene.is_bound():
            self._scene.go_on_from_shown()
        else:
            self._bind = self._scene.begin_bind()

    def tick(self) -> None:
        """Goes on binding, or follows and refines; nothing where all is settled."""
        self._guarded(self._tick)

    def scene_changed(self) -> None:
        """Follows the handles where they moved."""
        if self._bind is None:
            self._guarded(self._follow_if_bound)

    def unsettle(self) -> None:
        """The scene wants something else from here on, even where no step has looked yet."""
        self.is_settled = False

    def undone(self) -> None:
        """Goes on from what undo or redo has brought; the next step follows the handles anew."""
        self._matrices = None
        if self._bind is None:
            self._guarded(self._scene.go_on_from_shown)

    def keep(self, *, is_settling: bool = True) -> None:
        """Ends the act with the pose, settled first; where there is none yet, everything is restored."""
        if not self._has_followed:
            self.cancel()
            return
        if self._bind is None and is_settling:
            self._guarded(self._settle)
        self._finish(End(Ending.KEEP))

    def cancel(self, message: str = "") -> None:
        self._finish(End(Ending.RESTORE, message))

    def leave(self, message: str) -> None:
        self._finish(End(Ending.LEAVE, message))

    def fail(self, error: Exception) -> None:
        self._finish(End(Ending.RESTORE, f"Posing has ended and everything is as before: {error}", error))

    def _guarded(self, step: Callable[[], None]) -> None:
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
            if self._has_followed:
                self.leave(f"{error}. The pose is kept and posing has ended")
            else:
                self.fail(error)
        except Exception as error:  # noqa: BLE001 - whatever it is, the artist's mesh and handles come first
            self.fail(error)
        finally:
            self._is_busy = False

    def _tick(self) -> None:
        if self._bind is None and self._scene.is_bound():
            self._follow(is_refining=True)
        elif self._bind is None:
            self._bind = self._scene.begin_bind()
        elif self._bind.is_done:
            bind, self._bind = self._bind, None
            bind.adopt()
            self._matrices = None
        else:
            self._bind.start()

    def _follow_if_bound(self) -> None:
        if self._scene.is_bound():
            self._follow(is_refining=False)

    def _follow(self, *, is_refining: bool) -> None:
        matrices = self._scene.matrices()
        self._has_followed = True
        if self._matrices is None or not np.array_equal(matrices, self._matrices):
            self._matrices = matrices
            self._iterations_here = 0
            self._update(None, FOLLOW_TIME_LIMIT_S)
        elif is_refining and not self.is_settled:
            self._refine(REFINE_TIME_LIMIT_S)

    def _refine(self, time_limit_s: float) -> None:
        # In one go: each solve forgets what conjugate gradients have learned in the one before.
        left = self._scene.iteration_limit() - self._iterations_here
        self._update(max(1, left), time_limit_s)

    def _settle(self) -> None:
        self._follow_if_bound()
        if not self.is_settled and self._scene.is_bound():
            self._refine(KEEP_TIME_LIMIT_S)

    def _update(self, iterations: int | None, time_limit_s: float) -> None:
        self.readout = self._scene.update(iterations, time_limit_s)
        self._iterations_here += self.readout.iterations
        self.is_settled = (
            self.readout.stop_reason == "converged" or self._iterations_here >= self._scene.iteration_limit()
        )

    def _finish(self, end: End) -> None:
        if self.end is not None:
            return
        if self._bind is not None:
            self._bind.drop()
        self.end = end


def print_fault(end: End) -> None:
    """Prints where a fault of ours comes from: the report on it needs more than a sentence."""
    if end.error is not None and not isinstance(end.error, (ValueError, RuntimeError)):
        traceback.print_exception(end.error)


def status_text(act: PoseAct) -> str:
    """What the status bar says: state, then keys."""
    if act.phase is Phase.BINDING:
        return f"ARAP Pose: preparing the mesh, {act.bind_fraction:.0%}   |   Esc: cancel"
    state = "settled" if act.is_settled else "following"
    return (
        f"ARAP Pose: {state}   |   G, R, S: move, turn, scale a handle   |   Ctrl Z: take a move back"
        "   |   Enter: keep   |   Esc: cancel"
    )
