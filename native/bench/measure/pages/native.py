# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.native, and of what was measured in Blender: frames, drags in a window, the overlay."""

from __future__ import annotations

from collections.abc import Sequence
from statistics import median

from ..base.machine import ISA_NAMES
from .markdown import ENERGIES, NOTHING, Row, joined, machine_line, markdown, measured, medians, not_run_lines, number

ACTS = {"pose": "Pose", "pull": "ARAP Pull", "blend": "Blend"}


def native(data: Row) -> str:
    meshes = data["meshes"]
    rates = [median(of_threads) for of_threads in zip(*(mesh["dram_gb_per_s"] for mesh in meshes), strict=True)]
    dram = ", ".join(map(number, rates))
    return joined(
        machine_line(data["machine"], f"memory is read at {dram} GB/s by 1, 2, ... threads"),
        native_acts(meshes),
        native_iterations(meshes),
        not_run_lines(row for mesh in meshes for row in mesh["rows"]),
    )


def native_acts(meshes: Sequence[Row]) -> str:
    """Cost of each act with the fastest instruction set and its best number of threads."""
    headers = ["mesh", "energy", "threads", "bind", "new constraints", "local", "global", "iteration", "per solve"]
    headers += ["to 1.1", "to 1.01", "solve, GB/s", "read limit, GB/s", "peak MB"]
    lines = []
    for mesh in meshes:
        for descent in mesh["descents"]:
            row = best_row(mesh, descent["energy"], descent["isa"])
            if row is None:
                continue
            near = (near_of(descent, "1.1"), near_of(descent, "1.01"))
            times = (row[key] for key in ("bind_ms", "refactor_ms", "local_ms", "global_ms", "iteration_ms"))
            once = row["once_ms"] or None  # a difference; 0 if it is below the noise
            rates = (row.get("solve_gb_per_s"), row["read_gb_per_s"], row["peak_mb"])
            name = f"{mesh['mesh']}, {mesh['n_vertices']}"
            cells = (*map(number, times), number(once), *near, *map(number, rates))
            lines.append((name, ENERGIES[row["energy"]], str(row["threads"]), *cells))
    return markdown(headers, lines, 2)


def near_of(descent: Row, level: str) -> str:
    near = descent["near"][level]
    return number(near["ms"]) + ("" if descent["is_converged"] else "*") if near else NOTHING


def best_row(mesh: Row, energy: str, isa: str) -> Row | None:
    rows = [row for row in measured(mesh["rows"]) if row["energy"] == energy and row["isa"] == isa]
    return min(rows, key=lambda row: row["iteration_ms"], default=None)


def native_iterations(meshes: Sequence[Row]) -> str:
    """Times of an iteration by instruction set and threads, best in bold, and the default number of threads."""
    columns = list(dict.fromkeys((r["isa"], r["threads"]) for mesh in meshes for r in measured(mesh["rows"])))
    names = [f"{ISA_NAMES[isa]}, {threads}" for isa, threads in columns]
    lines = []
    for mesh in meshes:
        for descent in mesh["descents"]:
            energy = descent["energy"]
            rows = {
                (r["isa"], r["threads"]): r["iteration_ms"] for r in measured(mesh["rows"]) if r["energy"] == energy
            }
            best = min(rows.values(), default=None)
            cells = [number(rows.get(column)) for column in columns]
            bold = [f"**{c}**" if rows.get(k) == best else c for k, c in zip(columns, cells, strict=True)]
            lines.append((f"{mesh['mesh']}, {mesh['n_vertices']}", ENERGIES[energy], *bold, str(descent["threads"])))
    return markdown(("iteration, ms", "energy", *names, "default threads"), lines, 2)


def frame(results: Sequence[Row]) -> str:
    """Cost of a frame of posing in Blender, medians in milliseconds; one column a Blender and size."""
    return medians([f"Blender {r['blender']}, {r['vertices']}" for r in results], results)


def together(result: Row) -> str:
    """Cost of posing a heavy sculpt through a stand-in, medians in milliseconds."""
    column = f"Blender {result['blender']}, {result['vertices']} in {result['meshes']} meshes"
    memory = f"Peak memory beside the meshes: {number(result['peak_mb'])} MB."
    return joined(f"The stand-in has {result['stand_in']} vertices. {memory}", medians([column], [result]))


def drag(results: Sequence[Row]) -> str:
    """Cost of a frame of a drag, medians in milliseconds: a table for each Blender, a column an act and size."""
    blocks = []
    for blender in dict.fromkeys(r["blender"] for r in results):
        of_blender = [r for r in results if r["blender"] == blender]
        of_blender.sort(key=lambda r: (list(ACTS).index(r["act"]), r["vertices"]))
        columns = [f"{ACTS[r['act']]}, {r['vertices']}" for r in of_blender]
        blocks += [f"### Blender {blender}", medians(columns, of_blender)]
    return joined(*blocks)


def overlay(results: Sequence[Row]) -> str:
    """Cost of a redraw with the overlay, medians in milliseconds: a column a Blender."""
    return medians([f"Blender {r['blender']}" for r in results], results)
