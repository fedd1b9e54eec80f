# SPDX-License-Identifier: GPL-3.0-or-later
"""Shared by all pages of results: Markdown, numbers, names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

from ..base.machine import ISA_NAMES

Row = dict[str, Any]
LIBRARIES = {"ours": "ours", "libigl": "libigl", "open3d": "Open3D", "cgal": "CGAL"}
ENERGIES = {"rotation_nodes": "rotation nodes", "spokes_and_rims": "spokes-and-rims", "spokes": "spokes"}
NOTHING = "-"


def markdown(headers: Sequence[str], rows: Sequence[Sequence[str]], n_left: int = 1) -> str:
    """A table whose first ``n_left`` columns are words and the others numbers; empty without rows."""
    if not rows:
        return ""
    rule = ["---"] * n_left + ["---:"] * (len(headers) - n_left)
    return "\n".join("| " + " | ".join(line) + " |" for line in (headers, rule, *rows))


def number(value: float | None, digits: int = 3) -> str:
    """Significant digits without an exponent, whole numbers in full: 0.00234, 5.21, 1283."""
    if value is None:
        return NOTHING
    if value == 0:
        return "0"
    rounded = float(f"{value:.{digits}g}") if abs(value) < 10**digits else round(value)
    whole = len(str(int(abs(rounded))))
    places = max(0, digits - whole) if abs(rounded) >= 1 else _places_below_one(rounded, digits)
    return f"{rounded:.{places}f}"


def _places_below_one(value: float, digits: int) -> int:
    return digits - 1 - int(f"{abs(value):e}".partition("e")[2])


def medians(columns: Sequence[str], results: Sequence[Row]) -> str:
    """Medians in milliseconds of results with "ms" and "load", one column a result."""
    names = list(dict.fromkeys(name for r in results for name in r["ms"]))
    lines = [(name, *(number(r["ms"].get(name, {}).get("median")) for r in results)) for name in names]
    lines.append(("load before the run", *(str(r["load"]) for r in results)))
    return markdown(("ms", *columns), lines)


def machine_line(machine: Row, *more: str) -> str:
    """The machine and the day of the measurement, in one line."""
    parts = [
        str(machine["processor"]),
        f"{machine['cores']} cores",
        f"{machine['memory_gib']} GiB",
        f"load before the run {machine['load']}",
        *more,
        str(machine["day"]),
    ]
    return "*" + "; ".join(parts) + ".*"


def not_run_lines(rows: Iterable[Row]) -> str:
    """One line for each row that could not be measured, with the reason; empty if all were."""
    lines = []
    for row in rows:
        if "not_run" in row:
            name = LIBRARIES[row["library"]] if "library" in row else ISA_NAMES.get(row.get("isa", ""), "")
            energy = f", {ENERGIES[row['energy']]}" if row.get("energy") else ""
            lines.append(f"- Not run: {name}{energy}: {row['not_run']}")
    return "\n".join(dict.fromkeys(lines))


def joined(*blocks: str) -> str:
    """Joins blocks of Markdown by empty lines, without the empty blocks."""
    return "\n\n".join(block for block in blocks if block)


def replace_section(document: str, name: str, body: str) -> str:
    """Replaces the text between <!-- measured: NAME --> and <!-- end of NAME -->.

    Raises:
        ValueError: the document does not have the two markers exactly once.
    """
    begin, end = f"<!-- measured: {name} -->", f"<!-- end of {name} -->"
    found, n = re.subn(
        re.escape(begin) + ".*?" + re.escape(end),
        lambda _: f"{begin}\n\n{body.strip()}\n\n{end}",
        document,
        flags=re.DOTALL,
    )
    if n != 1:
        raise ValueError(f"the document has {n} sections {begin} ... {end}, must have one")
    return found


def measured(rows: Iterable[Row]) -> list[Row]:
    return [row for row in rows if "not_run" not in row]
