# SPDX-License-Identifier: GPL-3.0-or-later
"""Lines on the console."""

import io
import sys

import pytest
from arap_deform.scene.console import say


@pytest.mark.parametrize(("encoding", "line"), [("cp1252", "Ünï \\u2713\n"), ("utf-8", "Ünï ✓\n")])
def test_what_the_console_cannot_show_is_written_in_another_way(encoding, line):
    console = io.TextIOWrapper(io.BytesIO(), encoding=encoding, newline="\n")
    say("Ünï ✓", console)
    assert console.buffer.getvalue().decode(encoding) == line


def test_a_stream_of_text_takes_all(monkeypatch):
    monkeypatch.setattr("sys.stdout", io.StringIO())
    say("✓")
    assert sys.stdout.getvalue() == "✓\n"
