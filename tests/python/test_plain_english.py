# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on is written in plain English: some words are always a sign that it is not."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2] / "addon" / "arap_deform"
FILES = sorted(ROOT.rglob("*.py"))
EVERYWHERE = re.compile(r"\b(shall|anew|that which)\b", re.IGNORECASE)
IN_TEXTS = re.compile(r"\b(those that|at most|by then|held by nothing)\b", re.IGNORECASE)


def texts(source: str) -> Iterator[ast.Constant]:
    """String constants that are no docstrings: labels, tooltips, messages."""
    tree = ast.parse(source)
    lone = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in lone:
            yield node


def test_the_search_finds_texts_but_not_docstrings():
    source = '"""Shall."""\nname = "It shall"\nraise ValueError(f"{name} at most")\n'
    assert [node.value for node in texts(source)] == ["It shall", " at most"]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_words(path):
    source = path.read_text(encoding="utf-8")
    lines = [(number, line) for number, line in enumerate(source.splitlines(), 1) if EVERYWHERE.search(line)]
    found = lines + [(node.lineno, node.value) for node in texts(source) if IN_TEXTS.search(node.value)]
    assert not found, "say it in plain English"
