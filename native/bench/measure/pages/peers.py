# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.peers: ours beside other libraries."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from .markdown import (
    ENERGIES,
    LIBRARIES,
    NOTHING,
    Row,
    joined,
    machine_line,
    markdown,
    measured,
    not_run_lines,
    number,
)


def peers(data: Row) -> str:
    parts = (f"{data['threads']} threads for all that use them", f"{data['budget_s']:g} s for each library")
    blocks = [machine_line(data["machine"], *parts)]
    for mesh in data["meshes"]:
        rows = mesh["rows"]
        blocks += [f"### {mesh['mesh']}, {mesh['n_vertices']} vertices", peer_times(rows), not_run_lines(rows)]
    return joined(*blocks)


def peer_times(rows: Sequence[Row]) -> str:
    """Time and memory of each library, how fast it got near its minimum, and where it ended."""
    headers = ["library", "energy", "bind, ms", "iteration, ms", "/ ours", "peak MB", "to 1.01, ms", "iterations"]
    ours = {row["energy"]: row for row in measured(rows) if row["library"] == "ours"}
    lines = [
        (
            f"{LIBRARIES[row['library']]} {row['version']}" if row["library"] != "ours" else LIBRARIES["ours"],
            ENERGIES[row["energy"]],
            number(row["bind_ms"]),
            number(row["iteration_ms"]),
            number(round_ratio(row, ours.get(row["energy"])), 2),
            number(row["peak_mb"]),
            near_ms(row),
            str(row["near"]["iterations"]) if row["near"] else NOTHING,
            number(row["energies"]["spokes"]),
            number(row["energies"]["spokes_and_rims"]),
        )
        for row in measured(rows)
    ]
    return markdown([*headers, "E spokes", "E spokes-and-rims"], lines, 2)


def near_ms(row: Row) -> str:
    """Milliseconds to near the minimum, with * if it is not the library's own; else how long its longest run was."""
    if row["near"]:
        return number(row["near"]["ms"]) + ("" if row["is_converged"] else "*")
    return f"not in {number(1e-3 * max(run[1] for run in row['runs']))} s"


def round_ratio(theirs: Row, ours: Row | None) -> float | None:
    """Time of their iteration over the time of ours: the median of the ratios within each round."""
    if ours is None or theirs is ours:
        return None
    pairs = zip(theirs["iteration_ms_of_rounds"], ours["iteration_ms_of_rounds"], strict=False)
    return float(median(a / b for a, b in pairs))
