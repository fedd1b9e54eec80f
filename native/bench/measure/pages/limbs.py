# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.limbs and their pictures."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from .markdown import NOTHING, Row, joined, machine_line, markdown, measured, number
from .quality import IMAGES, PanelRow, rendered, together

MODEL_NAMES = {"surface": "Surface", "solid": "Solid", "firm": "Solid, Keep Volume 1", "skinned": "linear skinning"}
PICTURES = {"rod": "A rod on two bones", "creature": "The creature's paw"}  # by mesh
MB = 1e6


def sections(data: Row) -> dict[str, str]:
    """The Markdown of each section of docs/quality.md that has results."""
    parts: dict[str, Callable[[Any], str]] = {
        "limbs": limbs,
        "fingers": fingers,
        "densities": densities,
        "turned": turned,
        "cost": cost,
    }
    bodies = {f"solid-{part}": table(data[part]) for part, table in parts.items() if part in data}
    if "solid-limbs" in bodies:
        bodies["solid-limbs"] = joined(machine_line(data["machine"]), bodies["solid-limbs"])
    return bodies


def limbs(entries: Row) -> str:
    """One row a limb and model, and the pictures."""
    lines = [
        (f"{entry['mesh']}: {entry['pose']}", MODEL_NAMES[model], *limb_cells(row))
        for entry in entries.values()
        for model, row in entry["rows"].items()
    ]
    headers = ("limb", "model", "volume", "thinnest section", "max °", "iterations", "seconds")
    pictures = [f"![{title}]({IMAGES}/{picture_file(mesh)})" for mesh, title in PICTURES.items()]
    return joined(markdown(headers, lines, 2), *pictures)


def limb_cells(row: Row) -> tuple[str, ...]:
    shares = (f"{row[key]:.3f}" for key in ("volume", "section"))
    solved = (str(row["iterations"]), number(row["s"], 2)) if row["iterations"] else (NOTHING, NOTHING)
    return (*shares, number(row["max_deg"], 2), *solved)


def fingers(rows: Sequence[Row]) -> str:
    lines = [(MODEL_NAMES[row["model"]], number(row["cubes"], 2), f"{row['moved']:.3f}") for row in rows]
    return markdown(("two fingers", "cubes a finger", "the other moved"), lines)


def densities(rows: Sequence[Row]) -> str:
    lines = [
        (f"{row['mesh']}: {row['pose']}", MODEL_NAMES[row["model"]], together(map(str, row["n_vertices"])), *gaps(row))
        for row in rows
    ]
    return markdown(("pose", "model", "vertices", "moved, max, %", "moved, rms, %"), lines, 2)


def turned(rows: Sequence[Row]) -> str:
    lines = [(f"{row['mesh']}: {row['pose']}", *gaps(row), number(100 * row["pairs"]["rms"], 2)) for row in rows]
    return markdown(("mesh turned three ways", "off, max, %", "off, rms, %", "two of them, rms, %"), lines)


def gaps(row: Row) -> tuple[str, ...]:
    """The largest distances and the roots of mean squares, in percent."""
    return tuple(together(number(100 * gap[key], 2) for gap in row["gaps"]) for key in ("max", "rms"))


def cost(rows: Sequence[Row]) -> str:
    """What a bind, new constraints and a frame take."""
    lines = [
        (
            str(row["n_vertices"]),
            MODEL_NAMES[row["model"]],
            *(number(row[key], 2) for key in ("bind_s", "constraints_s")),
            number(1e3 * row["frame_s"], 2),
            number(row.get("to_surface"), 2),
            number(row["bytes_a_vertex"] * row["n_vertices"] / MB, 3),
            number(row["bytes_a_vertex"], 2),
        )
        for row in measured(rows)
    ]
    seconds = ("bind, s", "new constraints, s", "frame, ms", "frame / Surface's")
    return markdown(("vertices", "model", *seconds, "memory, MB", "bytes a vertex"), lines, 2)


def picture_file(mesh: str) -> str:
    return f"quality-limbs-{mesh}.webp"


def panels(entries: Row, mesh: str, folder: Path) -> list[PanelRow]:
    """A row for each limb of a sample that is beside skinning: its models from the surface on."""
    return rendered(
        (
            entry["pose"].rpartition(", ")[2],
            [(MODEL_NAMES[model].removesuffix(" 1"), folder / f"{name}-{model}.png") for model in entry["rows"]],
        )
        for name, entry in entries.items()
        if entry["is_sample"] and entry["mesh"] == mesh and "skinned" in entry["rows"]
    )
