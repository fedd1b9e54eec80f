# SPDX-License-Identifier: GPL-3.0-or-later
"""Results as Markdown tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from .convergence import median, ratio
from .machine import ISA_NAMES
from .published import ENERGY_MESHES, GUESSES, MOVES, PUBLISHED_S, PUBLISHED_SOLVERS_S

Row = dict[str, Any]
LIBRARIES = {"ours": "ours", "libigl": "libigl", "open3d": "Open3D", "cgal": "CGAL"}
ENERGIES = {"spokes": "spokes", "spokes_and_rims": "spokes-and-rims"}
NOTHING = "-"


def markdown(headers: Sequence[str], rows: Iterable[Sequence[str]], n_left: int = 1) -> str:
    """A table whose first ``n_left`` columns are words and the others numbers."""
    rule = ["---"] * n_left + ["---:"] * (len(headers) - n_left)
    return "\n".join("| " + " | ".join(line) + " |" for line in (headers, rule, *rows))


def number(value: float | None, digits: int = 3) -> str:
    """So many significant digits, never an exponent, whole numbers in full: 0.00234, 5.21, 1283."""
    if value is None:
        return NOTHING
    if value == 0:
        return "0"
    rounded = float(f"{value:.{digits}g}") if abs(value) < 10**digits else round(value)
    whole = len(str(int(abs(rounded))))
    places = max(0, digits - whole) if abs(rounded) >= 1 else _places_below_one(rounded, digits)
    return f"{rounded:.{places}f}"


def _places_below_one(value: float, digits: int) -> int:
    return digits - 1 - int(f"{abs(value):e}".partition("e")[2])


def machine_line(machine: Row, *more: str) -> str:
    """What it was measured on, in one line."""
    parts = [
        str(machine["processor"]),
        f"{machine['cores']} cores",
        f"{machine['memory_gib']} GiB",
        f"load before the run {machine['load']}",
        *more,
        str(machine["day"]),
    ]
    return "*" + "; ".join(parts) + ".*"


def library_name(row: Row) -> str:
    name = LIBRARIES[row["library"]]
    return f"{name}, {ISA_NAMES[row['isa']]}" if row.get("isa") else name


def not_run_lines(rows: Iterable[Row]) -> str:
    """One line for each row that could not be measured, with the reason; no text where there is none."""
    lines = []
    for row in rows:
        if "not_run" in row:
            name = library_name(row) if "library" in row else ISA_NAMES.get(row.get("isa", ""), "")
            energy = f", {ENERGIES[row['energy']]}" if row.get("energy") else ""
            lines.append(f"- Not run: {name}{energy}: {row['not_run']}")
    return "\n".join(dict.fromkeys(lines))


def joined(*blocks: str) -> str:
    """Blocks of Markdown with an empty line between; empty ones are left out."""
    return "\n\n".join(block for block in blocks if block)


# Peers


def peers(data: Row) -> str:
    blocks = [machine_line(data["machine"], f"{data['threads']} threads for all that use them")]
    for mesh in data["meshes"]:
        rows = mesh["rows"]
        blocks += [f"### {mesh['mesh']}, {mesh['n_vertices']} vertices", peer_times(rows), peer_energies(rows, data)]
        blocks += [peer_ratios(rows), not_run_lines(rows)]
    return joined(*blocks)


def measured(rows: Iterable[Row]) -> list[Row]:
    return [row for row in rows if "not_run" not in row]


def peer_times(rows: Sequence[Row]) -> str:
    """Time and memory of each library."""
    headers = ("library", "energy", "bind, ms", "iteration, ms", "cores used", "peak MB", "of it before the bind")
    lines = [
        (
            f"{library_name(row)} {row['version']}" if row["library"] != "ours" else library_name(row),
            ENERGIES[row["energy"]],
            number(row["bind_ms"]),
            number(row["iteration_ms"]),
            number(row["cores_used"], 2),
            number(row["peak_mb"]),
            number(row["before_mb"]),
        )
        for row in measured(rows)
    ]
    return markdown(headers, lines, 2)


def peer_energies(rows: Sequence[Row], data: Row) -> str:
    """How far each got and how fast."""
    headers = ("library", "energy", "ms to 1.01 of the minimum", "iterations", "E spokes", "E spokes-and-rims")
    lines = [
        (
            library_name(row),
            ENERGIES[row["energy"]],
            near_ms(row, data["budget_s"]),
            str(row["near"]["iterations"]) if row["near"] else NOTHING,
            number(row["energies"]["spokes"], 4),
            number(row["energies"]["spokes_and_rims"], 4),
        )
        for row in measured(rows)
    ]
    return markdown(headers, lines, 2)


def near_ms(row: Row, budget_s: float) -> str:
    """Milliseconds to near the minimum, with * where that is not its own; or how long it was given in vain."""
    if row["near"]:
        return number(row["near"]["ms"]) + ("" if row["is_converged"] else "*")
    return f"not in {number(1e-3 * max(run[1] for run in row['runs']))} s (of {budget_s:g} s)"


def peer_ratios(rows: Sequence[Row]) -> str:
    """How many times faster an iteration is with ours, for each of our instruction sets."""
    ours = {(row["isa"], row["energy"]): row for row in measured(rows) if row["library"] == "ours"}
    isas = list(dict.fromkeys(isa for isa, _ in ours))
    headers = ("times the iteration of ours", "energy", *(ISA_NAMES[isa] for isa in isas))
    lines = [
        (
            library_name(row),
            ENERGIES[row["energy"]],
            *(number(round_ratio(row, ours.get((isa, row["energy"])))) for isa in isas),
        )
        for row in measured(rows)
        if row["library"] != "ours"
    ]
    return markdown(headers, lines, 2) if lines else ""


def round_ratio(theirs: Row, ours: Row | None) -> float | None:
    """Median of the ratios within each round."""
    if ours is None:
        return None
    pairs = zip(theirs["iteration_ms_of_rounds"], ours["iteration_ms_of_rounds"], strict=False)
    ratios = [value for value in (ratio(a, b) for a, b in pairs) if value is not None]
    return median(ratios) if ratios else None


# The library by itself


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
    """What each act costs with the fastest instruction set, on the number of threads that is best there."""
    headers = ["mesh", "energy", "threads", "bind", "new constraints", "local", "global", "iteration"]
    headers += ["to 1.1", "to 1.01", "solve, GB/s", "read limit, GB/s", "peak MB"]
    lines = []
    for mesh in meshes:
        for descent in mesh["descents"]:
            row = best_row(mesh, descent["energy"], descent["isa"])
            if row is None:
                continue
            near = (near_of(descent, "1.1"), near_of(descent, "1.01"))
            times = (row[key] for key in ("bind_ms", "refactor_ms", "local_ms", "global_ms", "iteration_ms"))
            rates = (row.get("solve_gb_per_s"), row["read_gb_per_s"], row["peak_mb"])
            name = f"{mesh['mesh']}, {mesh['n_vertices']}"
            cells = (*map(number, times), *near, *map(number, rates))
            lines.append((name, ENERGIES[row["energy"]], str(row["threads"]), *cells))
    return markdown(headers, lines, 2)


def near_of(descent: Row, level: str) -> str:
    near = descent["near"][level]
    return number(near["ms"]) + ("" if descent["is_converged"] else "*") if near else NOTHING


def best_row(mesh: Row, energy: str, isa: str) -> Row | None:
    rows = [row for row in measured(mesh["rows"]) if row["energy"] == energy and row["isa"] == isa]
    return min(rows, key=lambda row: row["iteration_ms"], default=None)


def native_iterations(meshes: Sequence[Row]) -> str:
    """Times of an iteration by instruction set and threads, the best bold, and what the library takes by itself."""
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
    return markdown(("iteration, ms", "energy", *names, "threads by itself"), lines, 2)


def frame(results: Sequence[Row]) -> str:
    """What a frame of posing costs in Blender, medians in milliseconds; one column a Blender and size."""
    if not results:
        return ""
    headers = ("ms", *(f"Blender {r['blender']}, {r['vertices']}" for r in results))
    names = list(dict.fromkeys(name for r in results for name in r["ms"]))
    lines = [(name, *(number(r["ms"].get(name, {}).get("median")) for r in results)) for name in names]
    return markdown(headers, lines)


# The student report


def report(data: Row) -> str:
    blocks = [
        machine_line(data["machine"]),
        report_times(data),
        report_solvers(data),
        report_energies(data),
        report_guesses(data),
    ]
    return joined(*blocks)


def mesh_label(row: Row) -> str:
    return f"{row['mesh']}, {row['n_vertices']}" if "n_vertices" in row else str(row["mesh"])


def cell(result: Row, key: str, digits: int = 3) -> str:
    return f"not run: {result['not_run']}" if "not_run" in result else number(result[key], digits)


def report_times(data: Row) -> str:
    headers = ["bind + 200 iterations, s", "report, one thread", "report, OpenMP", "ours, one thread"]
    headers += [f"ours, {data['cores']} threads", "ours, by itself"]
    lines = []
    for row in data["times"]:
        published = [f"{value:.2f}" for value in PUBLISHED_S[row["mesh"]]]
        if "not_run" in row:
            lines.append((mesh_label(row), *published, f"not run: {row['not_run']}", NOTHING, NOTHING))
        else:
            lines.append((mesh_label(row), *published, *(cell(row[key], "total_s") for key in ("one", "all", "own"))))
    return markdown(headers, lines)


def report_solvers(data: Row) -> str:
    meshes = list(dict.fromkeys(mesh_label(row) for row in data["solvers"]))
    headers = ["solver, s", "report"]
    for mesh in meshes:
        headers += [mesh, "energy"]
    lines = []
    for solver in dict.fromkeys(row["solver"] for row in data["solvers"]):
        published = PUBLISHED_SOLVERS_S.get(solver)
        line = [solver or "the one there is", f"{published:.2f}" if published else NOTHING]
        for mesh in meshes:
            found = [row for row in data["solvers"] if row["solver"] == solver and mesh_label(row) == mesh]
            line += [cell(found[0], "total_s"), cell(found[0], "energy", 6)] if found else [NOTHING, NOTHING]
        lines.append(line)
    return markdown(headers, lines) if lines else ""


def report_energies(data: Row) -> str:
    lines = [(mesh_label(row), *(cell(row[move], "energy", 4) for move in MOVES)) for row in data["energies"]]
    lines += [(name, NOTHING, NOTHING, NOTHING) for name in ENERGY_MESHES if name not in _names(data["energies"])]
    return markdown(("energy after 200 iterations", *MOVES), lines)


def report_guesses(data: Row) -> str:
    names = {"rest": "rest", "naive_laplacian": "naive Laplacian", "handle_rotations": "handles' rotations"}
    headers = ("energy after 200 iterations, large move", *(names.get(guess, "as in a drag") for guess in GUESSES))
    lines = [(mesh_label(row), *(cell(row[guess], "energy", 5) for guess in GUESSES)) for row in data["guesses"]]
    return markdown(headers, lines) if lines else ""


def _names(rows: Iterable[Row]) -> set[str]:
    return {row["mesh"] for row in rows}
