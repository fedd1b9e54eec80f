# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.compare and their pictures.

    python -m measure.pages.compare

Prints the names of the pictures that the document shows.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from ..inputs.compared import file_part
from . import marks
from .markdown import NOTHING, Row, joined, machine_line, markdown, measured, number
from .quality import PanelRow, rendered
from .same_models import same_models

Cell = Callable[[Row], str]


def fixed(key: str, places: int = 3, scale: float = 1.0) -> Cell:
    return lambda row: NOTHING if row.get(key) is None else f"{scale * row[key]:.{places}f}"


def digits(key: str, scale: float = 1.0) -> Cell:
    return lambda row: NOTHING if row.get(key) is None else number(scale * row[key], 2)


COLUMNS: dict[str, Cell] = {
    "thin": fixed("thin"),
    "volume": fixed("volume"),
    "section": fixed("section"),
    "strain": fixed("strain"),
    "area": fixed("area"),
    "max °": digits("max_deg"),
    "rms °": digits("dihedral_rms"),
    "flips": fixed("flips", 0),
    "crossed": fixed("self_intersections", 0),
    "off, %": fixed("off", 2, 100),
    "density, %": fixed("density", 2, 100),
    "mirror, %": fixed("asymmetry", 3, 100),
    "parted, %": fixed("parted", 2, 100),
    "stray, %": fixed("stray", 2, 100),
    "set-up, s": digits("set_up_s"),
    "step, ms": digits("frame_s", 1000),
    "MB": digits("peak_mb"),
}
COSTS = "set-up, s", "step, ms", "MB"
PICTURE_TASKS = {
    "bar_twist_by_135": "twist",
    "rod_bend_by_120": "bend",
    "plane_pulled_up": "pull",
    "creature_paw_knee_of_90": "paw",
    "figure_arm_raised": "arm",
}
PICTURE_MODELS = (
    "surface, rotation nodes",
    "surface, spokes and rims",
    "solid",
    "solid, Keep Volume",
    "solid, bones",
    "tetrahedra",
    "Poisson, harmonic",
    "graph, affine",
    "graph, as published",
    "cage, mean value",
    "cage, Green",
    "libigl: biharmonic",
    "libigl: bounded biharmonic weights",
    "Blender: Laplacian Deform",
    "Blender: Armature",
)
PICTURE = "comparison-models.webp"


def sections(data: Row) -> dict[str, str]:
    """The Markdown of each section of docs/comparison.md that has results."""
    models = models_of(data)
    found = {
        "comparison-marks": joined(machine_line(data["machine"]), marks.table(data, models), marks.legend()),
        "comparison-set-up": joined(set_up(data, models), inputs(data["inputs"])),
        "comparison-sizes": sizes(data["sizes"]),
        "comparison-same-models": same_models(data["same_models"]) if "same_models" in data else "",
    }
    return {name: body for name, body in found.items() if body}


def models_of(data: Row) -> list[str]:
    return list(dict.fromkeys(model for entry in data["tasks"].values() for model in entry["rows"]))


def tables(data: Row) -> dict[str, str]:
    """The section of docs/comparison-tables.md."""
    versions = "; ".join(f"{library} {version}" for library, version in data["versions"].items())
    of_tasks = (task_table(entry) for entry in data["tasks"].values())
    return {"comparison-tables": joined(machine_line(data["machine"], versions), *of_tasks)}


def task_table(entry: Row) -> str:
    """One row a model, with the columns that any has; and why the others have none."""
    title = f"## {entry['mesh']}: {entry['pose']}\n{entry['n_vertices']} vertices."
    rows = {model: row for model, row in entry["rows"].items() if "not_run" not in row}
    columns = [name for name, cell in COLUMNS.items() if any(cell(row) != NOTHING for row in rows.values())]
    lines = [(model, *(COLUMNS[name](row) for name in columns)) for model, row in rows.items()]
    missing: dict[str, list[str]] = {}
    for model, row in entry["rows"].items():
        if "not_run" in row:
            missing.setdefault(row["not_run"], []).append(model)
    reasons = [f"- {'; '.join(names)}: {reason}" for reason, names in missing.items()]
    return joined(title, markdown(("model", *columns), lines), "\n".join(reasons))


def acts(done: Sequence[str]) -> str:
    """One after the other; the same ones are counted."""
    return ", ".join(f"{n} times {act}" if n > 1 else act for act, n in Counter(done).items())


def inputs(given: dict[str, str]) -> str:
    """A line for each sentence about what models are given, with those of which it is true."""
    return "\n".join(
        f"- {'; '.join(model for model, said in given.items() if said == sentence)}: {sentence}"
        for sentence in dict.fromkeys(given.values())
    )


def sizes(rows: list[Row]) -> str:
    """One row a model: its costs at each size; at what size it failed is in the last cell."""
    counts = sorted({row["n_vertices"] for row in rows})
    headers = ("model", *(f"{name} at {count}" for name in COSTS for count in counts))
    found = {(row["model"], row["n_vertices"]): row for row in measured(rows)}
    lines = [
        (model, *(COLUMNS[name](found.get((model, count), {})) for name in COSTS for count in counts))
        for model in dict.fromkeys(model for model, _ in found)
    ]
    return markdown(headers, lines)


def set_up(data: Row, models: Sequence[str]) -> str:
    """What a person does to set a model up, and how many dirty meshes it poses."""
    lines = []
    for model in models:
        rows = [row for entry in data["tasks"].values() for row in [entry["rows"].get(model, {})] if "acts" in row]
        dirty = data["dirty"].get(model, {})
        bound = f"{dirty['n_bound']} of {dirty['n_meshes']}" if "n_bound" in dirty else NOTHING
        if rows:
            lines.append((model, acts(rows[0]["acts"]), bound))
    return markdown(("model", "acts of a person", "dirty meshes"), lines, 2)


def panels(folder: Path) -> list[PanelRow]:
    """A row for each model that is shown: its tasks side by side."""
    return rendered(
        (model, [(title, folder / f"{picture_name(task, model)}.png") for task, title in PICTURE_TASKS.items()])
        for model in PICTURE_MODELS
    )


def picture_name(task: str, model: str) -> str:
    return f"{task}-{file_part(model)}"


def main() -> None:
    print(*(picture_name(task, model) for model in PICTURE_MODELS for task in PICTURE_TASKS))


if __name__ == "__main__":
    main()
