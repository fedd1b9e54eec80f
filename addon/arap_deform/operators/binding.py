# SPDX-License-Identifier: GPL-3.0-or-later
"""Work in a thread of its own that tells how far it is and can be dropped. No bpy."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Generic, TypeVar

from ..session import Progress

Result = TypeVar("Result")


class Binding(Generic[Result]):
    """Runs ``work(progress)`` in a thread, from construction on.

    ``work`` must not touch Blender's data: only the main thread may.
    """

    def __init__(self, work: Callable[[Progress], Result]) -> None:
        self._work = work
        self._fraction = 0.0
        self._is_dropped = False
        self._result: Result | None = None
        self._error: BaseException | None = None
        # No daemon: Python would kill it inside the native code when Blender quits, and that aborts. Quitting ends the
        # act first, which drops the work, so there is little to wait for.
        self._thread = threading.Thread(target=self._run, name="arap-bind", daemon=False)
        self._thread.start()

    @property
    def fraction(self) -> float:
        """Fraction done, 0 to 1."""
        return self._fraction

    @property
    def is_done(self) -> bool:
        return not self._thread.is_alive()

    def drop(self) -> None:
        """Asks the work to stop and does not wait for it; its result is thrown away."""
        self._is_dropped = True

    def wait(self, timeout_s: float | None = None) -> None:
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
