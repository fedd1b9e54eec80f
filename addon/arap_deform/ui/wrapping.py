# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences broken into lines of a width. Needs no Blender."""

from __future__ import annotations

from collections.abc import Callable


def wrap(text: str, width: float, measure: Callable[[str], float]) -> list[str]:
    """The words of ``text`` in lines not wider than ``width``; a word that is wider has a line of its own.

    Args:
        text: words separated by white space.
        width: in whatever unit ``measure`` has.
        measure: how wide a line is.
    """
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else ""
        if lines and measure(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
