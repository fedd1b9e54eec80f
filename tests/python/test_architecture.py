# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/architecture.md names files that are there, and leaves no room out."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
LIBRARY, ADDON = ROOT / "native" / "src", ROOT / "addon" / "arap_deform"
ROW = re.compile(r"^\| (`[^|]+`) \| [^|]+ \| (.+) \|$", re.MULTILINE)
NAME = re.compile(r"`([a-z][a-z_]*)(/?)`")


def rows(heading: str) -> list[tuple[str, str]]:
    """The rooms of a row, and what it names."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    section = text.split(f"\n### {heading}", 1)[1].split("\n## ", 1)[0].split("\n### ", 1)[0]
    return [(row[1], row[2]) for row in ROW.finditer(section)]


def named(heading: str, folder: Path, suffixes: tuple[str, ...]) -> list[tuple[str, str, Path, tuple[str, ...]]]:
    return [
        (rooms, name + slash, folder, suffixes) for rooms, text in rows(heading) for name, slash in NAME.findall(text)
    ]


NAMES = named("The library", LIBRARY, (".h", ".cpp")) + named("The add-on", ADDON, (".py",))


@pytest.mark.parametrize(("rooms", "name", "folder", "suffixes"), NAMES, ids=lambda value: str(value)[:40])
def test_a_name_is_a_file_or_a_folder_of_its_room(rooms, name, folder, suffixes):
    places = [folder / room for room in NAME.sub(r"\1", rooms).split(", ")]
    if name.endswith("/"):
        assert any((place / name).is_dir() for place in places)
    else:
        assert any(path.stem == name and path.suffix in suffixes for place in places for path in place.rglob("*"))


@pytest.mark.parametrize(("heading", "folder", "source"), [("The library", LIBRARY, "h"), ("The add-on", ADDON, "py")])
def test_every_room_is_there(heading, folder, source):
    rooms = {room for rooms, _ in rows(heading) for room, _ in NAME.findall(rooms)}
    assert rooms == {path.relative_to(folder).parts[0] for path in folder.glob(f"*/**/*.{source}")}
