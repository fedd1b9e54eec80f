# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of measure.runs.same_models."""

from __future__ import annotations

from .markdown import NOTHING, Row, joined, markdown, measured, number

HEADERS = (
    "ours", "theirs", "task", "apart", "energy", "set-up, s", "theirs, s", "step, ms", "theirs, ms", "theirs / ours",
)  # fmt: skip


def same_models(data: Row) -> str:
    """A row for each pair and task; then which pairs did not run, and which models ours are not like."""
    rows = data["rows"]
    missing = "\n".join(f"- {row['theirs']}, {row['task']}: {row['not_run']}" for row in rows if "not_run" in row)
    alone = f"No model of ours is the same as {'; '.join(data['alone'])}." if data["alone"] else ""
    return joined(markdown(HEADERS, [cells(row) for row in measured(rows)], 3), missing, alone)


def cells(row: Row) -> tuple[str, ...]:
    set_up, step = ([number(value, 2) for value in values] for values in (row["set_up_s"], in_ms(row["step_s"])))
    theirs = f"{row['theirs']} ({row['version']})"
    names = row["ours"], theirs, row["task"].replace("_", " ")
    return (*names, f"{row['distance']:.0e}", excess(row["energies"]), *set_up, *step, number(row["step_ratio"], 2))


def in_ms(seconds: list[float]) -> list[float]:
    return [1e3 * value for value in seconds]


def excess(energies: list[float] | None) -> str:
    """By how much theirs is above ours, as a share of it."""
    return NOTHING if energies is None else f"{energies[1] / energies[0] - 1.0:+.0e}"
