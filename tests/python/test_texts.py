# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts of the interface can be translated: none is put together before it is looked up."""

import ast
import functools
import re
from collections.abc import Iterator
from pathlib import Path
from string import Formatter

import pytest
from arap_deform import texts
from arap_deform.translation_german import MESSAGES

ADDON = Path(__file__).resolve().parents[2] / "addon" / "arap_deform"
# What the script interface says is Python's: English, as all that Python raises.
INTERFACE = sorted(
    {
        *ADDON.glob("*panel*.py"),
        *ADDON.glob("operators/*.py"),
        *(set(ADDON.glob("live*.py")) - {ADDON / "live_key.py", ADDON / "live_session.py"}),
        *ADDON.glob("overlay*.py"),
        *(ADDON / name for name in ("first_pose.py", "menus.py", "preferences.py", "pull_draw.py")),
    }
)
WORD = re.compile(r"[A-Za-z]{3}")
IDENTIFIER = re.compile(r"[a-z_.]*")


def composed_texts(source: str) -> Iterator[tuple[int, str]]:
    """Lines and texts of f-strings that have words in them, but for those that are raised or printed."""
    tree = ast.parse(source)
    is_english: set[int] = set()
    for node in ast.walk(tree):
        is_print = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "print"
        if isinstance(node, ast.Raise) or is_print:
            is_english |= {id(inner) for inner in ast.walk(node)}
    for node in ast.walk(tree):
        if isinstance(node, ast.JoinedStr) and id(node) not in is_english:
            text = "".join(str(part.value) for part in node.values if isinstance(part, ast.Constant))
            if WORD.search(text) and not IDENTIFIER.fullmatch(text):
                yield node.lineno, text


@functools.cache
def literals() -> set[str]:
    """All texts that are written out in the add-on, but for the translations."""
    return {
        node.value
        for path in ADDON.rglob("*.py")
        if not path.name.startswith("translation_")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }


@pytest.mark.parametrize("path", INTERFACE, ids=lambda path: path.name)
def test_no_text_is_put_together_before_it_is_looked_up(path: Path) -> None:
    assert list(composed_texts(path.read_text(encoding="utf-8"))) == []


def test_the_look_finds_what_it_is_for() -> None:
    wrong = 'label(text=f"Baked {n} keys")\nraise ValueError(f"No key {n}")\nname = f"use_mirror_{axis}"\n'
    assert list(composed_texts(wrong)) == [(1, "Baked  keys")]


@pytest.mark.parametrize("text", MESSAGES)
def test_a_translated_text_is_one_of_the_add_on(text: str) -> None:
    assert text in literals()


@pytest.mark.parametrize(("text", "translated"), MESSAGES.items())
def test_a_translation_has_the_same_places_to_fill(text: str, translated: str) -> None:
    def places(form: str) -> list[tuple[str | None, str | None]]:
        return [(name, spec) for _, name, spec, _ in Formatter().parse(form) if name is not None]

    assert places(translated) == places(text)


def test_without_blender_texts_are_english() -> None:
    assert texts.iface_("Pins") == texts.tip_("Pins") == texts.rpt_("Pins") == "Pins"
