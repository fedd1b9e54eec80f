# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences broken into lines: nothing is lost, no line is too wide, none could be longer."""

import pytest
from arap_deform.ui.wrapping import wrap

TEXT = "Select the vertices to move, for example a hand. An empty appears there."


@pytest.mark.parametrize("width", [8, 12, 25, 40, 200])
def test_lines_are_as_long_as_they_may_be(width: int) -> None:
    lines = wrap(TEXT, width, len)
    assert " ".join(lines) == TEXT
    assert all(len(line) <= width or " " not in line for line in lines)
    following = [line.split()[0] for line in lines[1:]]
    assert all(len(f"{line} {word}") > width for line, word in zip(lines, following, strict=False))


def test_a_word_that_is_too_wide_is_broken() -> None:
    """As a long name: Blender would cut its middle out."""
    assert wrap("an extraordinarily long one", 5, len) == ["an", "extra", "ordin", "arily", "long", "one"]
    assert wrap("no room", 0, len) == [*"noroom"]


def test_widths_are_those_of_the_letters() -> None:
    def measure(line: str) -> float:
        return 4.0 * line.count("m") + 1.0 * (len(line) - line.count("m"))

    assert wrap("iii mmm", 16.0, measure) == ["iii mmm"]
    assert wrap("iii mmm", 15.0, measure) == ["iii", "mmm"]


def test_no_text_has_no_lines() -> None:
    assert wrap("  ", 10, len) == []
