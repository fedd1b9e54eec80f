# SPDX-License-Identifier: GPL-3.0-or-later
"""What the artist waits for, and when that is shown: nothing flickers for work that is soon done. No bpy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

SHOWN_AFTER_S = 0.5


@dataclass(frozen=True)
class Wait:
    """What is waited for now.

    Attributes:
        text: one line.
        fraction: of it done, 0 to 1.
        seconds: that it has lasted.
        ends_on_esc: whether Esc over a 3D view ends it.
    """

    text: str
    fraction: float
    seconds: float
    ends_on_esc: bool = True


class Binding(Protocol):
    """A mesh that may be bound now."""

    @property
    def is_binding(self) -> bool: ...

    @property
    def bind_fraction(self) -> float: ...

    @property
    def bind_s(self) -> float:
        """Seconds that it has lasted."""


def wait_for_bind(object_name: str, binding: Binding, *, ends_on_esc: bool = True) -> Wait | None:
    """The wait for a mesh that is bound, None if it is not."""
    if not binding.is_binding:
        return None
    text = f"Preparing {object_name}, {binding.bind_fraction:.0%}"
    return Wait(text, binding.bind_fraction, binding.bind_s, ends_on_esc)


class Waiter(Protocol):
    """Something that may be waited for."""

    def wait(self) -> Wait | None:
        """What is waited for now, None if nothing is. Does not raise."""


class Waiters:
    """Those that are waited for now. A timer calls look() as long as there are any."""

    def __init__(self) -> None:
        self._waiters: list[Waiter] = []
        self._looks: tuple[object, ...] = ()
        self.shown: tuple[Waiter, Wait] | None = None
        """The one that has lasted longest; None if none has lasted long."""

    def add(self, waiter: Waiter) -> None:
        """look() forgets it again when it does not wait any more."""
        if waiter not in self._waiters:
            self._waiters.append(waiter)

    def look(self) -> bool:
        """Finds what is shown. Returns whether that looks different from the last time."""
        waits = [(waiter, wait) for waiter in self._waiters if (wait := waiter.wait()) is not None]
        self._waiters = [waiter for waiter, _ in waits]
        long = [pair for pair in waits if pair[1].seconds >= SHOWN_AFTER_S]
        self.shown = max(long, key=lambda pair: pair[1].seconds, default=None)
        before, self._looks = self._looks, _looks_of(self.shown)
        return self._looks != before

    @property
    def is_empty(self) -> bool:
        return not self._waiters

    def clear(self) -> None:
        self._waiters.clear()
        self._looks, self.shown = (), None


def _looks_of(shown: tuple[Waiter, Wait] | None) -> tuple[object, ...]:
    if shown is None:
        return ()
    _, wait = shown
    return wait.text, f"{wait.fraction:.0%}", wait.ends_on_esc
