# SPDX-License-Identifier: GPL-3.0-or-later
"""Marks from the figures of measure.runs.compare: a model at its worst over the tasks that ask for something."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from .markdown import NOTHING, Row, markdown, number

MARKS = ("○", "●", "●●", "●●●")
AT_SIZE = 100_000  # vertices that the time of a step is judged at
Figure = Callable[[Row, str], float | None]  # of the results, for a model; None: not measured


class Criterion(NamedTuple):
    """What a column of marks says.

    Attributes:
        title: of the column.
        meaning: what is judged, as a sentence without its end.
        figure: what is judged.
        limits: for three, two and one mark; decreasing if more is better.
        scale, unit: of the limits in words.
    """

    title: str
    meaning: str
    figure: Figure
    limits: tuple[float, float, float]
    scale: float = 1.0
    unit: str = ""

    def mark(self, data: Row, model: str) -> str:
        value = self.figure(data, model)
        if value is None:
            return NOTHING
        is_more_better = self.limits[0] > self.limits[-1]
        reached = [value >= limit if is_more_better else value <= limit for limit in self.limits]
        return MARKS[sum(reached)]

    def in_words(self) -> str:
        sign = "≥" if self.limits[0] > self.limits[-1] else "≤"
        limits = ", ".join(number(self.scale * limit, 2) for limit in self.limits)
        return f"*{self.title}*: {self.meaning}, {sign} {limits}{self.unit}"


def lowest(key: str, *tasks: str) -> Figure:
    return _over(min, key, tasks)


def highest(key: str, *tasks: str) -> Figure:
    return _over(max, key, tasks)


def _over(worst: Callable[[Sequence[float]], float], key: str, tasks: Sequence[str]) -> Figure:
    """The worst over the tasks named, over all if none is; None if a task is not measured."""

    def figure(data: Row, model: str) -> float | None:
        found = [data["tasks"].get(task, {}).get("rows", {}).get(model, {}) for task in tasks or data["tasks"]]
        values = [row[key] for row in found if row.get(key) is not None]
        is_whole = len(values) == len(found) if tasks else bool(values)
        return worst(values) if is_whole else None

    return figure


def step_at_size(data: Row, model: str) -> float | None:
    """Seconds of a step at AT_SIZE vertices."""
    rows = [entry for entry in data.get("sizes", []) if entry["model"] == model and "frame_s" in entry]
    return next((row["frame_s"] for row in rows if abs(row["n_vertices"] / AT_SIZE - 1) < 0.3), None)


def share_bound(data: Row, model: str) -> float | None:
    """Of the dirty meshes, the share that the model binds."""
    entry = data.get("dirty", {}).get(model)
    return entry["n_bound"] / entry["n_meshes"] if entry and "n_bound" in entry else None


TWISTS = "rod_twist_by_180", "bar_twist_by_135"
BENDS = "rod_bend_by_120", "bar_bend_by_90"
RODS = "rod_twist_by_180", "rod_bend_by_120"
CRITERIA = (
    Criterion("volume", "what is left of it after twists and bends", lowest("volume", *TWISTS, *BENDS),
              (0.95, 0.85, 0.7), 100, " %"),
    Criterion("limb", "what is left of the smallest section of a round one", lowest("section", *RODS),
              (0.95, 0.85, 0.5), 100, " %"),
    Criterion("smooth", "largest change of a dihedral angle in these", highest("max_deg", *TWISTS, *BENDS),
              (10, 20, 45), unit="°"),
    Criterion("move", "the same in the sheet that is pulled up", highest("max_deg", "plane_pulled_up"), (15, 20, 45),
              unit="°"),
    Criterion("target", "farthest vertex from its target", highest("off"), (1e-4, 5e-3, 2e-2), 100, " %"),
    Criterion("density", "how far from the same pose of a finer mesh", highest("density", *TWISTS, *BENDS),
              (1e-3, 5e-3, 2e-2), 100, " %"),
    Criterion("speed", f"one large move of {AT_SIZE // 1000} thousand vertices, to its end", step_at_size,
              (0.1, 1.0, 10.0), unit=" s"),
    Criterion("any mesh", "dirty meshes that bind", share_bound, (0.95, 0.75, 0.5), 100, " %"),
)  # fmt: skip


def table(data: Row, models: Sequence[str]) -> str:
    headers = ("model", *(criterion.title for criterion in CRITERIA))
    return markdown(headers, [(model, *(c.mark(data, model) for c in CRITERIA)) for model in models])


def legend() -> str:
    """What the columns mean, a line each."""
    return "\n".join(f"- {criterion.in_words()}." for criterion in CRITERIA)
