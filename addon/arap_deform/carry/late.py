# SPDX-License-Identifier: GPL-3.0-or-later
"""Followers that are not up to date yet, and why one failed. By names of objects, since undo replaces all data."""

from __future__ import annotations

from collections.abc import Iterable

keys: dict[str, set[str]] = {}
"""Names of the body's keys whose twins are to be written, by the name of the follower. None of them: look at it."""
faults: dict[str, str] = {}
"""Why the last write has failed, by the name of the follower."""
told: dict[str, str] = {}
"""What was said last of a follower where there is no list to look at."""
edited: set[str] = set()
"""Names of bodies and followers that are in Edit or Sculpt Mode."""


def add(follower: str, names: Iterable[str] = ()) -> set[str]:
    """Notes keys. Returns all that are noted."""
    noted = keys.setdefault(follower, set())
    noted.update(names)
    return noted


def done(follower: str, names: Iterable[str]) -> None:
    """These are up to date."""
    noted = keys.get(follower, set())
    noted.difference_update(names)
    if not noted:
        keys.pop(follower, None)


def waiting() -> list[str]:
    """The followers that are late, without those that have failed: they wait for the next motion."""
    return [name for name in keys if name not in faults]


def clear() -> None:
    for noted in (keys, faults, told, edited):
        noted.clear()
