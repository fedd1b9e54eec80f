# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison as one page of plots to look around in; needs plotly.

    python -m measure.pages.interactive COMPARE.json PAGE.html

The page is a single file: it needs no server and no network.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import plotly.graph_objects as go
from plotly.io import to_html

from .compare import models_of
from .markdown import Row, measured, number
from .marks import CRITERIA, MARKS

ROW_PX = 22  # of a model in a plot
HEAD_PX = 180


class Metric(NamedTuple):
    """What is shown of a row: its key, its title with the unit, and what the key is multiplied by for that."""

    key: str
    title: str
    scale: float = 1.0
    is_spread: bool = False  # over several powers of ten


METRICS = (
    Metric("thin", "thinnest part, of that at rest"),
    Metric("volume", "volume, of that at rest"),
    Metric("section", "smallest section, of that at rest"),
    Metric("strain", "strain of edges, rms"),
    Metric("area", "distortion of areas, rms of logarithms"),
    Metric("max_deg", "largest change of a dihedral angle, °"),
    Metric("dihedral_rms", "change of dihedral angles, rms, °"),
    Metric("flips", "flipped faces"),
    Metric("self_intersections", "faces that cross others"),
    Metric("off", "farthest vertex from its target, % of the diagonal", 100),
    Metric("density", "from the same pose of a finer mesh, % of the diagonal", 100, is_spread=True),
    Metric("asymmetry", "from the mirrored pose, % of the diagonal", 100, is_spread=True),
    Metric("parted", "change of distance of what lies side by side, % of the diagonal", 100),
    Metric("stray", "motion of what should stay, % of the diagonal", 100),
    Metric("set_up_s", "set-up, s", is_spread=True),
    Metric("frame_s", "step, ms", 1000, is_spread=True),
    Metric("peak_mb", "memory, MB", is_spread=True),
)
STEP = next(metric for metric in METRICS if metric.key == "frame_s")


def page(data: Row) -> str:
    models = models_of(data)
    figures = [
        ("At a glance", marks_plot(data, models)),
        ("One figure, all tasks", tables_plot(data, models)),
        ("Shape against time", trade_off_plot(data)),
    ]
    if data.get("sizes"):
        figures.append(("Time over size", sizes_plot(data)))
    parts = [
        f"<h2>{title}</h2>\n" + to_html(figure, include_plotlyjs=position == 0, full_html=False)
        for position, (title, figure) in enumerate(figures)
    ]
    head = '<!doctype html>\n<html lang="en"><meta charset="utf-8"><title>Models compared</title>'
    style = "<style>body{font-family:sans-serif;max-width:1200px;margin:2em auto;color:#222}</style>"
    return "\n".join([head, style, "<h1>Models compared</h1>", *parts, "</html>"])


def marks_plot(data: Row, models: Sequence[str]) -> go.Figure:
    marks = [[criterion.mark(data, model) for criterion in CRITERIA] for model in models]
    levels = [[MARKS.index(mark) if mark in MARKS else None for mark in line] for line in marks]
    figure = go.Figure(
        go.Heatmap(
            z=levels, x=[criterion.title for criterion in CRITERIA], y=models, text=marks, texttemplate="%{text}",
            colorscale="YlGn", zmin=0, zmax=len(MARKS) - 1, showscale=False, hoverinfo="x+y+text",
        )
    )  # fmt: skip
    return as_table(figure, len(models))


def tables_plot(data: Row, models: Sequence[str]) -> go.Figure:
    """A cell a model and task; the metric is chosen."""
    tasks = {name: f"{entry['mesh']}: {entry['pose']}" for name, entry in data["tasks"].items()}
    figure = go.Figure()
    for metric in METRICS:
        cells = [[value(data["tasks"][task]["rows"].get(model, {}), metric) for task in tasks] for model in models]
        figure.add_heatmap(
            z=[[shade(cell, metric) for cell in line] for line in cells], x=list(tasks.values()), y=models,
            text=[["" if cell is None else number(cell) for cell in line] for line in cells], texttemplate="%{text}",
            colorscale="Viridis", showscale=False, visible=metric is METRICS[0], name="",
            hovertemplate="%{y}<br>%{x}<br>%{text}",
        )  # fmt: skip
    choose(figure, [metric.title for metric in METRICS], 1)
    return as_table(figure, len(models))


def trade_off_plot(data: Row) -> go.Figure:
    """How thin a part becomes over how long a step takes; the task is chosen."""
    figure = go.Figure()
    names: list[str] = []
    for entry in data["tasks"].values():
        rows = {model: row for model, row in entry["rows"].items() if value(row, METRICS[0]) is not None}
        if not rows:
            continue
        figure.add_scatter(
            x=[value(row, STEP) for row in rows.values()], y=[value(row, METRICS[0]) for row in rows.values()],
            text=list(rows), mode="markers+text", textposition="top center", visible=not names, name="",
            hovertemplate="%{text}<br>%{x:.3g} ms<br>%{y:.3f}",
        )  # fmt: skip
        names.append(f"{entry['mesh']}: {entry['pose']}")
    choose(figure, names, 1)
    figure.update_xaxes(type="log", title=STEP.title)
    figure.update_yaxes(title=METRICS[0].title)
    return figure.update_layout(height=650, template="simple_white")


def sizes_plot(data: Row) -> go.Figure:
    figure = go.Figure()
    shown = (STEP, *(metric for metric in METRICS if metric.key in ("set_up_s", "peak_mb")))
    lines: dict[str, list[Row]] = {}
    for row in measured(data["sizes"]):
        lines.setdefault(row["model"], []).append(row)
    for metric in shown:
        for model, rows in lines.items():
            of_size = sorted(rows, key=lambda row: row["n_vertices"])
            figure.add_scatter(
                x=[row["n_vertices"] for row in of_size], y=[value(row, metric) for row in of_size], name=model,
                mode="lines+markers", visible=metric is STEP,
            )  # fmt: skip
    choose(figure, [metric.title for metric in shown], len(lines))
    figure.update_xaxes(type="log", title="vertices").update_yaxes(type="log")
    return figure.update_layout(height=600, template="simple_white")


def value(row: Row, metric: Metric) -> float | None:
    found = row.get(metric.key)
    return None if found is None else metric.scale * found


def shade(cell: float | None, metric: Metric) -> float | None:
    """What a cell's colour goes by."""
    if cell is None or not metric.is_spread:
        return cell
    return math.log10(cell) if cell > 0 else None


def choose(figure: go.Figure, names: Sequence[str], n_traces: int) -> None:
    """A menu above a plot: of its traces, each name shows the next n_traces."""

    def shows(choice: int) -> list[bool]:
        return [position // n_traces == choice for position in range(n_traces * len(names))]

    buttons: list[dict[str, Any]] = [
        {"label": name, "method": "update", "args": [{"visible": shows(choice)}]} for choice, name in enumerate(names)
    ]
    menu = {"buttons": buttons, "x": 0, "xanchor": "left", "y": 1.02, "yanchor": "bottom"}
    figure.update_layout(updatemenus=[menu])


def as_table(figure: go.Figure, n_rows: int) -> go.Figure:
    figure.update_yaxes(autorange="reversed").update_xaxes(side="bottom")
    return figure.update_layout(height=HEAD_PX + ROW_PX * n_rows, template="simple_white")


def main() -> None:
    results, out = map(Path, sys.argv[1:])
    out.write_text(page(json.loads(results.read_text())))


if __name__ == "__main__":
    main()
