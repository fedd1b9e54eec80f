# SPDX-License-Identifier: GPL-3.0-or-later
"""Work in a thread of its own that tells how far it is and can be dropped. No bpy."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import GenericAlias
from typing import Any, Generic, TypeVar

from .session import Progress

Result = TypeVar("Result")

THREAD_NAME = "arap-bind"


def is_any_running() -> bool:
    """Whether some work is under way, dropped or not."""
    return bool(_threads())


def wait_for_binds() -> None:
    """Waits until no work is under way, in the main thread, before it calls an operator under a context override.

    See Binding for what happens otherwise. What was dropped ends soon; a bind of a million vertices takes seconds.
    """
    for thread in _threads():
        thread.join()


def _threads() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == THREAD_NAME]


class Binding(Generic[Result]):
    """Runs ``work(progress)`` in a thread, from start() on.

    ``work`` must not touch Blender's data: only the main thread may.

    Start it from a timer or from a function that then waits for it, never in an operator that returns while it runs:
    with Python before 3.12 Blender crashes where an operator that a script has called under a context override looks
    at its context while another thread holds Python's lock. It takes that thread's lock for its own. Whoever overrides
    the context calls wait_for_binds() before.
    """

    # typing never forgets a class that was subscripted, nor what its module holds, the module bpy for one. Where bpy is
    # a module of Python, Blender ends when that one goes: else Python ends it in the middle of its work, and it hangs.
    __class_getitem__: Any = classmethod(GenericAlias)

    def __init__(self, work: Callable[[Progress], Result]) -> None:
        self._work = work
        self._fraction = 0.0
        self._is_dropped = False
        self._result: Result | None = None
        self._error: BaseException | None = None
        # No daemon: Python would kill it inside the native code when Blender quits, and that aborts. Quitting ends the
        # act first, which drops the work, so there is little to wait for.
        self._thread = threading.Thread(target=self._run, name=THREAD_NAME, daemon=False)
        self._has_started = False

    def start(self) -> None:
        """Begins the work; again, or once it is dropped, it does nothing."""
        if not self._has_started and not self._is_dropped:
            self._has_started = True
            self._thread.start()

    @property
    def has_started(self) -> bool:
        return self._has_started

    @property
    def fraction(self) -> float:
        """Fraction done, 0 to 1."""
        return self._fraction

    @property
    def is_done(self) -> bool:
        return self._has_started and not self._thread.is_alive()

    def drop(self) -> None:
        """Asks the work to stop and does not wait for it; its result is thrown away."""
        self._is_dropped = True

    def wait(self, timeout_s: float | None = None) -> None:
        """Waits until it is done, or for so long; only once it has started."""
        self._thread.join(timeout_s)

    def result(self) -> Result:
        """What ``work`` returned; raises what it raised. Only when done."""
        if self._error is not None:
            raise self._error
        return self._result  # type: ignore[return-value]

    def _progress(self, fraction: float) -> bool:
        self._fraction = fraction
        return not self._is_dropped

    def _run(self) -> None:
        try:
            self._result = self._work(self._progress)
        except BaseException as error:  # noqa: BLE001 - raised again by result(), in the thread that asks
            self._error = error
