# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that are still free, numbered as Blender numbers them; and counts for messages."""

from __future__ import annotations

from collections.abc import Container, Sequence
from itertools import count

NAME_BYTES = 63  # Blender cuts names here
BASE_BYTES = 57  # of these, before .001 or .00001


def cut(name: str) -> str:
    """What Blender keeps of a name. Blender before 5.0 cuts inside a character, and Python cannot read the rest."""
    return name.encode()[:NAME_BYTES].decode(errors="ignore")


def unique(name: str, taken: Container[str]) -> str:
    """``name`` as Blender keeps it, numbered if it is taken."""
    name = cut(name)
    return numbered(name, taken) if name in taken else name


def numbered(name: str, taken: Container[str]) -> str:
    """The first of name.001, name.002 ... that is not taken; a long name is cut, so that the number stays."""
    base = name.encode()[:BASE_BYTES].decode(errors="ignore")
    return next(found for found in (f"{base}.{i:03d}" for i in count(1)) if found not in taken)


def sentences(reasons: Sequence[str], most: int = 20) -> str:
    """'A. B', each once, and how many more there are. A reason is a sentence without a full stop."""
    all_of_them = list(dict.fromkeys(reasons))
    more = len(all_of_them) - most
    return ". ".join(all_of_them[:most] + ([f"And {more} more"] if more > 0 else []))


def counted(n: int, noun: str) -> str:
    """'1 key' or '2 keys'."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def listed(names: Sequence[str], most: int = 3) -> str:
    """'a, b, c and 4 more'."""
    shown = ", ".join(names[:most])
    return shown if len(names) <= most else f"{shown} and {len(names) - most} more"
