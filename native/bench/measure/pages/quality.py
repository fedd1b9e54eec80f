# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.quality and their pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from ..inputs.mesh import short_count
from .markdown import NOTHING, Row, joined, machine_line, markdown, number

MODEL_NAMES = {"plain": "plain", "nodes": "rotation nodes"}
PanelRow = tuple[str, list[tuple[str, Path]]]  # a title, and the title and file of each picture
IMAGES, KINDS_PICTURE, KINDS_A_ROW = "images", "quality-kinds.webp", 4
SHAPE = ("∫ \\|dH\\| dA", "rms °", "99 % °", "max °", "> 60°", "flips")
COLUMNS = ("model", "vertices", "energy", *SHAPE, "iterations", "moved, %")


def sections(data: Row) -> dict[str, str]:
    """The Markdown of each section of docs/quality.md that has results."""
    bodies = {
        "quality-poses": joined(machine_line(data["machine"]), *map(pose, shown(data["poses"]).items())),
        "quality-walls": walls(data["poses"].values()),
        "quality-steps": steps(data["poses"].values()),
        "quality-kinds": kinds(data["kinds"]),
        "quality-drag": drag(data["drag"]),
        "quality-symmetry": symmetry(data["symmetry"]),
    }
    return {name: body for name, body in bodies.items() if body}


def shown(poses: Row) -> Row:
    """The poses with a table and a picture: not those in one step, which look like the same in several."""
    return {
        name: entry
        for name, entry in poses.items()
        if not any("from_steps" in row for rows in entry["rows"].values() for row in rows)
    }


def pose(item: tuple[str, Row]) -> str:
    """The table of one pose, and its picture if the mesh is a sample of ours."""
    name, entry = item
    title = f"{entry['mesh']}: {entry['pose']}"
    lines = [pose_line(model, row) for model, rows in entry["rows"].items() for row in rows]
    picture = f"![{title}]({IMAGES}/{picture_file(name)})" if entry["is_sample"] else ""
    return joined(f"### {title}", markdown(COLUMNS, lines), picture)


def pose_line(model: str, row: Row) -> tuple[str, ...]:
    near = NOTHING
    if row["near"]:
        iterations, is_known = row["near"]
        near = f"{iterations}" + ("" if is_known else "*")
    return (
        MODEL_NAMES[model],
        str(row["n_vertices"]),
        number(row["energy"]) + ("" if row["is_converged"] else "*"),
        number(row["curvature"]),
        *(number(row[key], 2) for key in ("rms_deg", "p99_deg", "max_deg")),
        str(row["sharp_edges"]),
        str(row["flips"]),
        near,
        number(100 * row["moved"], 2) if "moved" in row else NOTHING,
    )


def walls(entries: Iterable[Row]) -> str:
    """How well thin parts keep their walls apart."""
    lines = [
        (*name, number(100 * row["walls"]["passed"], 2), number(row["walls"]["median"], 2))
        for name, row in rows_with("walls", entries)
    ]
    return markdown(("", "vertices", "passed through, %", "thickness kept, median"), lines)


def steps(entries: Iterable[Row]) -> str:
    """Distance of a pose in one step from the same pose in several."""
    lines = [(*name, number(100 * row["from_steps"], 2)) for name, row in rows_with("from_steps", entries)]
    return markdown(("", "vertices", "from ten steps, %"), lines)


def rows_with(what: str, entries: Iterable[Row]) -> Iterator[tuple[tuple[str, str], Row]]:
    """The rows that have something, with their pose, model and number of vertices."""
    for entry in entries:
        for model, rows in entry["rows"].items():
            for row in rows:
                if what in row:
                    yield (f"{entry['pose']}, {MODEL_NAMES[model]}", str(row["n_vertices"])), row


def kinds(entries: Row) -> str:
    """Meshes of special kinds, and their picture."""
    lines = [
        (
            f"{entry['name']}, {MODEL_NAMES[model]}",
            str(row["n_vertices"]),
            number(row["max_deg"], 2),
            str(row["sharp_edges"]),
            str(row["flips"]),
            number(100 * row["off"], 2) if "off" in row else NOTHING,
        )
        for entry in entries.values()
        for model, row in entry["rows"].items()
    ]
    headers = ("", "vertices", "max °", "> 60°", "flips", "off, %")
    picture = f"![Special kinds of meshes, posed]({IMAGES}/{KINDS_PICTURE})"
    return joined(markdown(headers, lines), picture) if lines else ""


def kind_panels(entries: Row, folder: Path) -> list[PanelRow]:
    """Rows of rendered pictures, KINDS_A_ROW kinds each: for the same kinds one row a model."""
    names = list(entries)
    return rendered(
        (
            title,
            [(entries[name]["name"], folder / f"{name}-{model}.png") for name in names[first : first + KINDS_A_ROW]],
        )
        for first in range(0, len(names), KINDS_A_ROW)
        for model, title in MODEL_NAMES.items()
    )


def drag(models: dict[str, Row]) -> str:
    lines = []
    for model, row in models.items():
        start = (MODEL_NAMES[model], str(row["n_vertices"]))
        mean = sum(row["iterations"]) / len(row["iterations"])
        lines.append(
            (*start, number(row["frame_ms"]), number(mean, 2), *_behind(row["behind"]), number(row["load"], 2))
        )
        for n, behind in row["behind_of_iterations"].items():
            lines.append((*start, NOTHING, n, *_behind(behind), NOTHING))
    behind = ("behind, mean, %", "behind, max, %")
    headers = ("drag", "vertices", "ms a frame", "iterations a frame", *behind, "load after")
    return markdown(headers, lines)


def _behind(distances: list[float]) -> tuple[str, str]:
    """Mean and maximum in percent."""
    return number(100 * sum(distances) / len(distances), 2), number(100 * max(distances), 2)


def symmetry(models: dict[str, Row]) -> str:
    lines = [
        (MODEL_NAMES[model], str(row["n_vertices"]), f"{accuracy:.0e}", f"{distance:.0e}", number(row["moved"], 2))
        for model, row in models.items()
        for accuracy, distance in row["distances"]
    ]
    headers = ("mirrored pose", "vertices", "accuracy", "mirror error, max", "moved, max")
    return markdown(headers, lines)


def picture_file(name: str) -> str:
    return f"quality-{name}.webp"


def panels(name: str, entry: Row, folder: Path) -> list[PanelRow]:
    """For each model its rendered pictures from coarse to fine, with their titles."""
    return rendered(
        (
            MODEL_NAMES[model],
            [
                (short_count(row["n_vertices"]), folder / f"{name}-{model}-{level}.png")
                for level, row in enumerate(densities)
            ],
        )
        for model, densities in entry["rows"].items()
    )


def rendered(rows: Iterable[PanelRow]) -> list[PanelRow]:
    """The rows without pictures that are not there."""
    found = [(title, [(name, file) for name, file in files if file.exists()]) for title, files in rows]
    return [row for row in found if row[1]]
