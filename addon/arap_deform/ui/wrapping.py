# SPDX-License-Identifier: GPL-3.0-or-later
"""Wraps sentences to a width. No bpy."""

from __future__ import annotations

from collections.abc import Callable


def wrap(text: str, width: float, measure: Callable[[str], float]) -> list[str]:
    """The words of ``text`` in lines up to ``width`` wide. A wider word has a line of its own.

    Args:
        text: words separated by white space.
        width: in the unit of ``measure``.
        measure: the width of a line.
    """
    lines: list[str] = []
    for word in text.split():
        longer = f"{lines[-1]} {word}" if lines else ""
        if lines and measure(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines
