# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.followers and their picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from .markdown import Row, joined, machine_line, markdown, number
from .quality import IMAGES, PanelRow, rendered

PICTURE = "quality-followers.webp"
PICTURED = {"sleeve at 1.5 % of the limb": "sleeve", "shirt": "shirt"}  # and their titles
BODIES = {"surface": "Surface", "solid": "Solid"}


def sections(data: Row) -> dict[str, str]:
    """The Markdown of each section of docs/quality.md that has results."""
    parts: dict[str, Callable[[Any], str]] = {"worn": worn, "dirty": dirty, "cost": cost}
    bodies = {f"followers-{part}": table(data[part]) for part, table in parts.items() if part in data}
    if "followers-worn" in bodies:
        bodies["followers-worn"] = joined(machine_line(data["machine"]), bodies["followers-worn"])
    return bodies


def worn(rows: Sequence[Row]) -> str:
    lines = [(f"{row['follower']}, {row['pose']}", BODIES[row["body"]], row["model"], *worn_cells(row)) for row in rows]
    headers = ("follower", "body", "carried by", "inside, %", "deepest", "offset, rms")
    return joined(markdown(headers, lines, 3), f"![A sleeve and a shirt]({IMAGES}/{PICTURE})")


def worn_cells(row: Row) -> tuple[str, ...]:
    if "not_run" in row:
        return (row["not_run"], "", "")
    return number(100 * row["inside"], 2), number(row["deepest"], 2), number(row["offset_rms"], 2)


def dirty(found: Row) -> str:
    lines = [(model, f"{row['n_bound']} of {row['n_tasks']}") for model, row in found.items()]
    return markdown(("carried by", "bodies and followers that are dirty"), lines)


def cost(rows: Sequence[Row]) -> str:
    lines = [
        (
            row["model"],
            str(row["n_vertices"]),
            number(row.get("bind_s"), 2),
            number(1e3 * row["frame_s"], 2) if "frame_s" in row else row["not_run"],
        )
        for row in rows
    ]
    return markdown(("carried by", "vertices of each", "bind, s", "frame, ms"), lines)


def panels(rows: Sequence[Row], folder: Path) -> list[PanelRow]:
    """A row for each follower that is pictured: on the surface, all models."""
    return rendered(
        (
            title,
            [
                (row["model"].removeprefix("ours, ").removeprefix("Blender: "), folder / f"{row['picture']}.png")
                for row in rows
                if row["follower"] == follower and row["body"] == "surface" and "picture" in row
            ],
        )
        for follower, title in PICTURED.items()
    )
