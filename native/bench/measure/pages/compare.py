# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.compare and their pictures."""

from __future__ import annotations

from pathlib import Path

from ..inputs.compared import file_part
from . import marks
from .markdown import NOTHING, Row, joined, machine_line, markdown, measured, number
from .quality import PanelRow, rendered

HEADERS = (
    "model", "thin", "volume", "section", "strain", "area", "max °", "rms °", "flips", "crossed", "off, %",
    "density, %", "set-up, s", "step, ms", "MB",
)  # fmt: skip
SHARES = "thin", "volume", "section", "strain", "area"
COUNTS = "flips", "self_intersections"
PICTURE_TASKS = {
    "bar_twist_by_135": "twist",
    "rod_bend_by_120": "bend",
    "plane_pulled_up": "pull",
}
PICTURE_MODELS = {
    "surface, spokes and rims": "[SA07]",
    "surface, rotation nodes": "surface",
    "solid, Keep Volume": "solid",
    "Poisson, harmonic": "Poisson",
    "graph, affine": "graph",
    "cage, mean value": "cage",
}
PICTURE = "comparison-tasks.webp"


def sections(data: Row) -> dict[str, str]:
    """The Markdown of each section of docs/comparison.md that has results."""
    models = list(dict.fromkeys(model for entry in data["tasks"].values() for model in entry["rows"]))
    found = {
        "comparison-marks": joined(machine_line(data["machine"]), marks.table(data, models), marks.legend()),
        "comparison": joined(*(task_table(entry) for entry in data["tasks"].values())),
    }
    if "sizes" in data:
        found["comparison-sizes"] = sizes(data["sizes"])
    return found


def task_table(entry: Row) -> str:
    title = f"**{entry['mesh']}: {entry['pose']}**, {entry['n_vertices']} vertices"
    rows = entry["rows"].items()
    lines = [(model, *cells(row)) for model, row in rows if "not_run" not in row]
    missing = [f"- {model}: {row['not_run']}" for model, row in rows if "not_run" in row]
    return joined(title, markdown(HEADERS, lines), "\n".join(missing))


def cells(row: Row) -> tuple[str, ...]:
    """Of HEADERS but the first; what was not measured is NOTHING."""
    shares = (fixed(row.get(key), 3) for key in SHARES)
    angles = (number(row.get(key), 2) for key in ("max_deg", "dihedral_rms"))
    counts = (NOTHING if row.get(key) is None else str(row[key]) for key in COUNTS)
    percents = (fixed(row.get(key), 2, 100) for key in ("off", "density"))
    costs = number(row["set_up_s"], 2), number(1e3 * row["frame_s"], 2), number(row.get("peak_mb"), 2)
    return (*shares, *angles, *counts, *percents, *costs)


def fixed(value: float | None, places: int, scale: float = 1.0) -> str:
    return NOTHING if value is None else f"{scale * value:.{places}f}"


def sizes(rows: list[Row]) -> str:
    lines = [
        (row["model"], str(row["n_vertices"]), *cells(row)[-3:])
        for row in sorted(measured(rows), key=lambda row: (row["n_vertices"], row["frame_s"]))
    ]
    return markdown(("model", "vertices", *HEADERS[-3:]), lines)


def panels(tasks: Row, folder: Path) -> list[PanelRow]:
    """A row for each task that is shown: its models side by side."""
    return rendered(
        (title, [(short, folder / f"{name}-{file_part(model)}.png") for model, short in PICTURE_MODELS.items()])
        for name, title in PICTURE_TASKS.items()
        if name in tasks
    )
