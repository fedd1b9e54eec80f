# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.quality and their pictures."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from ..inputs.mesh import short_count
from .markdown import NOTHING, Row, joined, machine_line, markdown, number

MODEL_NAMES = {"plain": "plain", "nodes": "rotation nodes"}
PanelRow = tuple[str, list[tuple[str, Path]]]  # a title, and the title and file of each picture
IMAGES, KINDS_PICTURE, KINDS_A_ROW = "images", "quality-kinds.webp", 4
BENDS = ("max °", "> 60°", "flips")
POSES = ("pose", "model", "vertices", "∫ \\|dH\\| dA", *BENDS, "iterations", "moved, %")


def sections(data: Row) -> dict[str, str]:
    """The Markdown of each section of docs/quality.md that has results."""
    bodies = {
        "quality-poses": joined(machine_line(data["machine"]), poses(shown(data["poses"]))),
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


def poses(entries: Row) -> str:
    """One row a pose and model, and the pictures of those on samples of ours."""
    titles = {name: f"{entry['mesh']}: {entry['pose']}" for name, entry in entries.items()}
    lines = [
        (titles[name], MODEL_NAMES[model], *pose_cells(rows))
        for name, entry in entries.items()
        for model, rows in entry["rows"].items()
    ]
    samples = [name for name, entry in entries.items() if entry["is_sample"]]
    pictures = [f"![{titles[name]}]({IMAGES}/{picture_file(name)})" for name in samples]
    return joined(markdown(POSES, lines, 2), *pictures)


def pose_cells(rows: Sequence[Row]) -> tuple[str, ...]:
    near = [row["near"] for row in rows if row["near"]]
    return (
        together(str(row["n_vertices"]) for row in rows),
        together(number(row["curvature"], 2) + ("" if row["is_converged"] else "*") for row in rows),
        *bends(rows),
        together(f"{iterations}" + ("" if is_known else "*") for iterations, is_known in near),
        together(number(100 * row["moved"], 2) for row in rows if "moved" in row),
    )


def bends(rows: Sequence[Row]) -> tuple[str, ...]:
    """The cells of BENDS."""
    return (
        together(number(row["max_deg"], 2) for row in rows),
        together(str(row["sharp_edges"]) for row in rows),
        together(str(row["flips"]) for row in rows),
    )


def together(values: Iterable[str]) -> str:
    """The values of several densities in one cell, once if they are the same."""
    found = list(values)
    return ", ".join(found if len(set(found)) > 1 else found[:1]) or NOTHING


def walls(entries: Iterable[Row]) -> str:
    """How well thin parts keep their walls apart."""
    lines = [
        (
            *name,
            together(number(100 * row["walls"]["passed"], 2) for row in rows),
            together(number(row["walls"]["median"], 2) for row in rows),
        )
        for name, rows in rows_with("walls", entries)
    ]
    return markdown(("", "vertices", "passed through, %", "thickness kept, median"), lines)


def steps(entries: Iterable[Row]) -> str:
    """Distance of a pose in one step from the same pose in several."""
    lines = [
        (*name, together(number(100 * row["from_steps"], 2) for row in rows))
        for name, rows in rows_with("from_steps", entries)
    ]
    return markdown(("", "vertices", "from ten steps, %"), lines)


def rows_with(what: str, entries: Iterable[Row]) -> Iterator[tuple[tuple[str, str], list[Row]]]:
    """The rows of each pose and model that have something, with these and the numbers of vertices."""
    for entry in entries:
        for model, all_rows in entry["rows"].items():
            rows = [row for row in all_rows if what in row]
            if rows:
                vertices = together(str(row["n_vertices"]) for row in rows)
                yield (f"{entry['pose']}, {MODEL_NAMES[model]}", vertices), rows


def kinds(entries: Row) -> str:
    """Meshes of special kinds, each cell of plain and of rotation nodes, and their picture."""
    lines = [
        (
            entry["name"],
            str(rows[0]["n_vertices"]),
            *bends(rows),
            together(number(100 * row["off"], 2) for row in rows if "off" in row),
        )
        for entry in entries.values()
        for rows in [list(entry["rows"].values())]
    ]
    picture = f"![Special kinds of meshes, posed]({IMAGES}/{KINDS_PICTURE})"
    return joined(markdown(("plain, rotation nodes", "vertices", *BENDS, "off, %"), lines), picture) if lines else ""


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
        (
            MODEL_NAMES[model],
            str(row["n_vertices"]),
            together(f"{accuracy:.0e}" for accuracy, _ in row["distances"]),
            together(f"{distance:.0e}" for _, distance in row["distances"]),
            number(row["moved"], 2),
        )
        for model, row in models.items()
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
