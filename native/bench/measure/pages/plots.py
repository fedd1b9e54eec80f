# SPDX-License-Identifier: GPL-3.0-or-later
"""Results as small pictures; needs matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.image import imread

from ..base.machine import ISA_NAMES
from .markdown import ENERGIES, LIBRARIES, measured
from .native import best_row

COLORS = {"ours": "#c8501e", "libigl": "#3b6ea5", "cgal": "#5a8f4e", "open3d": "#8a6bb1"}
STYLES = {"rotation_nodes": "-.", "spokes_and_rims": "-", "spokes": "--"}


def plot_peers(data: dict[str, Any], path: Path) -> None:
    """Time of an iteration over the number of vertices, by library."""
    figure, axes = _figure()
    lines: dict[tuple[str, str], list[tuple[int, float]]] = {}
    for mesh in data["meshes"]:
        for row in measured(mesh["rows"]):
            lines.setdefault((row["library"], row["energy"]), []).append((mesh["n_vertices"], row["iteration_ms"]))
    for (library, energy), points in lines.items():
        _line(axes, points, f"{LIBRARIES[library]}, {ENERGIES[energy]}", COLORS[library], STYLES[energy])
    _finish(figure, axes, "vertices", "ms an iteration", path)


def plot_descents(data: dict[str, Any], path: Path) -> None:
    """Energy over time from rest on the largest mesh, spokes-and-rims."""
    figure, axes = _figure()
    mesh = max(data["meshes"], key=lambda mesh: mesh["n_vertices"])
    rows = [row for row in measured(mesh["rows"]) if row["energy"] == "spokes_and_rims"]
    lowest = min((row["minimum"] for row in rows), default=1.0)
    for row in rows:
        points = [(ms, energy / lowest) for _, ms, energy in row["runs"]]
        _line(axes, points, LIBRARIES[row["library"]], COLORS[row["library"]], "-")
    axes.set_title(mesh["mesh"], fontsize=9, loc="left")
    _finish(figure, axes, "ms from rest", "energy / lowest", path)


def plot_native(data: dict[str, Any], path: Path) -> None:
    """Time of an iteration of ours over the number of vertices, by instruction set, each on its best threads."""
    figure, axes = _figure()
    lines: dict[tuple[str, str], list[tuple[int, float]]] = {}
    for mesh in data["meshes"]:
        for isa, energy in dict.fromkeys((row["isa"], row["energy"]) for row in measured(mesh["rows"])):
            row = best_row(mesh, energy, isa)
            if row:
                lines.setdefault((isa, energy), []).append((mesh["n_vertices"], row["iteration_ms"]))
    shades = dict(zip(dict.fromkeys(isa for isa, _ in lines), ("#c8501e", "#3b6ea5", "#5a8f4e"), strict=False))
    for (isa, energy), points in lines.items():
        _line(axes, points, f"{ISA_NAMES[isa]}, {ENERGIES[energy]}", shades[isa], STYLES[energy])
    _finish(figure, axes, "vertices", "ms an iteration", path)


def plot_panels(rows: Sequence[tuple[str, Sequence[tuple[str, Path]]]], path: Path, dpi: int = 200) -> None:
    """Pictures in a grid: one row for each name, with the title and the file of each picture."""
    n_columns = max(len(pictures) for _, pictures in rows)
    _same_files()
    figure = Figure(figsize=(2.4 * n_columns, 2.5 * len(rows)), layout="constrained", dpi=dpi)
    grid = figure.subplots(len(rows), n_columns, squeeze=False)
    for axes in grid.ravel():
        axes.set_axis_off()
    for line, (name, pictures) in zip(grid, rows, strict=True):
        for axes, (title, file) in zip(line, pictures, strict=False):
            axes.imshow(imread(file))
            axes.set_title(f"{name}, {title}", fontsize=8)
    figure.savefig(path, pil_kwargs={"quality": 80, "method": 6})


def _figure() -> tuple[Figure, Axes]:
    _same_files()
    figure = Figure(figsize=(5.2, 3.2), layout="constrained")
    axes = figure.subplots()
    axes.set(xscale="log", yscale="log")
    axes.grid(visible=True, which="major", color="#dddddd", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    return figure, axes


def _same_files() -> None:
    """The same file from the same figures, and text as text."""
    mpl.rcParams.update({"svg.hashsalt": "arap", "svg.fonttype": "none", "font.size": 8})


def _line(axes: Axes, points: Sequence[tuple[float, float]], label: str, color: str, style: str) -> None:
    xs, ys = zip(*sorted(points), strict=True)
    axes.plot(xs, ys, style, marker="o", markersize=3, linewidth=1.2, label=label, color=color)


def _finish(figure: Figure, axes: Axes, x: str, y: str, path: Path) -> None:
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.legend(frameon=False, fontsize=7)
    figure.savefig(path, metadata={"Date": None})
