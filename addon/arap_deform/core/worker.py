# SPDX-License-Identifier: GPL-3.0-or-later
"""Work in a thread of its own. It tells how far it is, and it can be dropped."""

from __future__ import annotations

import threading
from collections.abc import Callable
from types import GenericAlias
from typing import Any, Generic, TypeVar

from .models import Progress

Result = TypeVar("Result")

THREAD_NAME = "arap-bind"


def is_any_running() -> bool:
    """Whether some work is under way, dropped or not."""
    return bool(_threads())


def wait_for_binds() -> None:
    """Waits until no work is under way. Call it in the main thread before an operator under a context override.

    Binding says why. Dropped work ends soon; a bind of a million vertices takes seconds.
    """
    for thread in _threads():
        thread.join()


def _threads() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == THREAD_NAME]


class Binding(Generic[Result]):
    """Runs ``work(progress)`` in a thread, from start() on.

    ``work`` must not touch Blender's data: only the main thread may.

    Start it from a timer, or from a function that then waits for it, never in an operator that returns while it runs.
    With Python before 3.12 Blender crashes if a script calls an operator under a context override and that operator
    looks at its context while another thread holds Python's lock: it takes that lock for its own. So call
    wait_for_binds() before you override the context.
    """

    # The module typing never forgets a class that was subscripted, and so keeps its module and bpy alive. If bpy is a
    # module of Python, Blender ends when bpy is freed. If it is never freed, Python ends Blender in the middle of its
    # work, and it hangs.
    __class_getitem__: Any = classmethod(GenericAlias)

    def __init__(self, work: Callable[[Progress], Result]) -> None:
        self._work = work
        self._fraction = 0.0
        self._is_dropped = False
        self._result: Result | None = None
        self._error: BaseException | None = None
        # No daemon: Python would kill it inside the native code when Blender quits, and that aborts. Quitting ends the
        # act before, and that drops the work, so there is little to wait for.
        self._thread = threading.Thread(target=self._run, name=THREAD_NAME, daemon=False)
        self._has_started = False

    def start(self) -> None:
        """Begins the work. Does nothing if it has begun or was dropped."""
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
        """Asks the work to stop and does not wait for it. Its result is thrown away."""
        self._is_dropped = True

    def wait(self, timeout_s: float | None = None) -> None:
        """Waits until it is done, or for that long. Only after start()."""
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
