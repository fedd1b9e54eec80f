# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.peers: ours beside other libraries."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from ..base.machine import ISA_NAMES
from .markdown import (
    ENERGIES,
    NOTHING,
    Row,
    joined,
    library_name,
    machine_line,
    markdown,
    measured,
    not_run_lines,
    number,
)  # fmt: skip


def peers(data: Row) -> str:
    parts = (f"{data['threads']} threads for all that use them", f"{data['budget_s']:g} s for each library")
    blocks = [machine_line(data["machine"], *parts)]
    for mesh in data["meshes"]:
        rows = mesh["rows"]
        blocks += [f"### {mesh['mesh']}, {mesh['n_vertices']} vertices", peer_times(rows), peer_ratios(rows)]
        blocks.append(not_run_lines(rows))
    return joined(*blocks)


def peer_times(rows: Sequence[Row]) -> str:
    """Time and memory of each library, how fast it got near its minimum, and where it ended."""
    headers = ["library", "energy", "bind, ms", "iteration, ms", "cores used", "peak MB", "before, MB"]
    headers += ["to 1.01, ms", "iterations", "E spokes", "E spokes-and-rims"]
    lines = [
        (
            f"{library_name(row)} {row['version']}" if row["library"] != "ours" else library_name(row),
            ENERGIES[row["energy"]],
            number(row["bind_ms"]),
            number(row["iteration_ms"]),
            number(row["cores_used"], 2),
            number(row["peak_mb"]),
            number(row["before_mb"]),
            near_ms(row),
            str(row["near"]["iterations"]) if row["near"] else NOTHING,
            number(row["energies"]["spokes"], 4),
            number(row["energies"]["spokes_and_rims"], 4),
        )
        for row in measured(rows)
    ]
    return markdown(headers, lines, 2)


def near_ms(row: Row) -> str:
    """Milliseconds to near the minimum, with * if it is not the library's own; else how long its longest run was."""
    if row["near"]:
        return number(row["near"]["ms"]) + ("" if row["is_converged"] else "*")
    return f"not in {number(1e-3 * max(run[1] for run in row['runs']))} s"


def peer_ratios(rows: Sequence[Row]) -> str:
    """Time of their iteration over the time of ours, for each of our instruction sets."""
    ours = {(row["isa"], row["energy"]): row for row in measured(rows) if row["library"] == "ours"}
    isas = list(dict.fromkeys(isa for isa, _ in ours))
    headers = ("iteration, theirs / ours", "energy", *(ISA_NAMES[isa] for isa in isas))
    lines = [
        (
            library_name(row),
            ENERGIES[row["energy"]],
            *(number(round_ratio(row, ours.get((isa, row["energy"])))) for isa in isas),
        )
        for row in measured(rows)
        if row["library"] != "ours"
    ]
    return markdown(headers, lines, 2)


def round_ratio(theirs: Row, ours: Row | None) -> float | None:
    """Median of the ratios within each round."""
    if ours is None:
        return None
    pairs = zip(theirs["iteration_ms_of_rounds"], ours["iteration_ms_of_rounds"], strict=False)
    return float(median(a / b for a, b in pairs))
