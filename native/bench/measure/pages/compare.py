# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.compare and their pictures."""

from __future__ import annotations

from pathlib import Path

from ..inputs.compared import file_part
from .markdown import NOTHING, Row, joined, machine_line, markdown, number
from .quality import IMAGES, PanelRow, rendered

HEADERS = (
    "model", "volume", "section", "strain", "max °", "flips", "off, %", "density, %", "set-up, s", "step, ms",
)  # fmt: skip
PICTURE_TASKS = {"rod_twist_by_180": "twist", "rod_bend_by_120": "bend", "plane_pulled_up": "pull"}
PICTURE_MODELS = {
    "surface, rotation nodes": "surface",
    "solid, Keep Volume": "solid",
    "Poisson, harmonic": "Poisson",
    "graph, affine": "graph",
}
PICTURE = "comparison-tasks.webp"


def sections(data: Row) -> dict[str, str]:
    """The Markdown of the section of docs/comparison.md."""
    tables = [task_table(entry) for entry in data["tasks"].values()]
    picture = f"![Twist, bend and pull by four models]({IMAGES}/{PICTURE})"
    return {"comparison": joined(machine_line(data["machine"]), picture, *tables)}


def task_table(entry: Row) -> str:
    title = f"**{entry['mesh']}: {entry['pose']}**, {entry['n_vertices']} vertices"
    return joined(title, markdown(HEADERS, [(model, *cells(row)) for model, row in entry["rows"].items()]))


def cells(row: Row) -> tuple[str, ...]:
    shares = (NOTHING if row[key] is None else f"{row[key]:.3f}" for key in ("volume", "section", "strain"))
    percents = (f"{100 * row[key]:.2f}" for key in ("off", "density"))
    times = number(row["set_up_s"], 2), number(1e3 * row["frame_s"], 2)
    return (*shares, number(row["max_deg"], 2), str(row["flips"]), *percents, *times)


def panels(tasks: Row, folder: Path) -> list[PanelRow]:
    """A row for each task that is shown: its models side by side."""
    return rendered(
        (title, [(short, folder / f"{name}-{file_part(model)}.png") for model, short in PICTURE_MODELS.items()])
        for name, title in PICTURE_TASKS.items()
        if name in tasks
    )
