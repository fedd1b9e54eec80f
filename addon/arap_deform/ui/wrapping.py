# SPDX-License-Identifier: GPL-3.0-or-later
"""Wraps sentences to a width. No bpy."""

from __future__ import annotations

from collections.abc import Callable, Iterator


def wrap(text: str, width: float, measure: Callable[[str], float]) -> list[str]:
    """The words of ``text`` in lines up to ``width`` wide. A wider word, as a long name, is broken.

    Args:
        text: words separated by white space.
        width: in the unit of ``measure``.
        measure: the width of a line.
    """
    lines: list[str] = []
    for part in (part for word in text.split() for part in _parts(word, width, measure)):
        longer = f"{lines[-1]} {part}" if lines else ""
        if lines and measure(longer) <= width:
            lines[-1] = longer
        else:
            lines.append(part)
    return lines


def _parts(word: str, width: float, measure: Callable[[str], float]) -> Iterator[str]:
    """The word in parts that fit, each as long as it may be, but at least a letter."""
    while word:
        n = len(word)
        while n > 1 and measure(word[:n]) > width:
            n -= 1
        yield word[:n]
        word = word[n:]
