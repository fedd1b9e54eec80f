# SPDX-License-Identifier: GPL-3.0-or-later
"""What is known of attached objects, by their uids: the bind, the keys to write, and what went wrong."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..core.attach.wrap import Wrap
    from .binding import Binding


@dataclass
class State:
    """Of one attached object.

    Attributes:
        wrap: the bind to its host.
        must_check: whether all arrays must be compared, to tell if the bind still fits.
        binding: the bind that is under way in the background.
        pending: names of the host's keys whose linked keys are to be written, none of them if only the list of linked
            keys is to be compared; None if all is up to date.
        error: why the last write failed.
        reported: what was printed last, where there is no list to look at.
    """

    wrap: Wrap | None = None
    must_check: bool = False
    binding: Binding | None = None
    pending: set[str] | None = None
    error: str = ""
    reported: str = ""

    def add_pending(self, names: Iterable[str] = ()) -> set[str]:
        """Queues keys. Returns all that are queued."""
        self.pending = (self.pending or set()) | set(names)
        return self.pending

    def done(self, names: Iterable[str]) -> None:
        """Takes keys that are up to date from the queue."""
        self.pending = (self.pending or set()).difference(names) or None


in_edit_mode: set[int] = set()
"""Hosts and attached objects that are in Edit or Sculpt Mode."""

_states: dict[int, State] = {}


def of(uid: int) -> State:
    """The state of an attached object, made if there is none."""
    return _states.setdefault(uid, State())


def queued() -> list[int]:
    """The objects with something to write, without those whose last write failed: they wait for the next motion."""
    return [uid for uid, state in _states.items() if state.pending is not None and not state.error]


def is_any_binding() -> bool:
    """Whether a bind is under way."""
    return any(state.binding is not None for state in _states.values())


def all_states() -> dict[int, State]:
    return dict(_states)


def forget(uid: int) -> None:
    """The object is attached no more."""
    _states.pop(uid, None)
    in_edit_mode.discard(uid)
