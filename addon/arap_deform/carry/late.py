# SPDX-License-Identifier: GPL-3.0-or-later
"""Followers that are not up to date yet, and why one failed. By uids of objects."""

from __future__ import annotations

from collections.abc import Iterable

keys: dict[int, set[str]] = {}
"""Names of the body's keys whose twins are to be written, by the follower. None of them: look at it."""
faults: dict[int, str] = {}
"""Why the last write has failed, by the follower."""
told: dict[int, str] = {}
"""What was said last of a follower where there is no list to look at."""
edited: set[int] = set()
"""Bodies and followers that are in Edit or Sculpt Mode."""


def add(follower: int, names: Iterable[str] = ()) -> set[str]:
    """Notes keys. Returns all that are noted."""
    noted = keys.setdefault(follower, set())
    noted.update(names)
    return noted


def done(follower: int, names: Iterable[str]) -> None:
    """These are up to date."""
    noted = keys.get(follower, set())
    noted.difference_update(names)
    if not noted:
        keys.pop(follower, None)


def waiting() -> list[int]:
    """The followers that are late, without those that have failed: they wait for the next motion."""
    return [uid for uid in keys if uid not in faults]


def forget(follower: int) -> None:
    """It goes along no more."""
    keys.pop(follower, None)
    faults.pop(follower, None)
    told.pop(follower, None)
    edited.discard(follower)


def clear() -> None:
    for noted in (keys, faults, told, edited):
        noted.clear()
