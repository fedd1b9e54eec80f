# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables of measure.runs.report."""

from __future__ import annotations

from ..runs.published import ENERGY_MESHES, GUESSES, MOVES, PUBLISHED_S, PUBLISHED_SOLVERS_S
from .markdown import NOTHING, Row, joined, machine_line, markdown, number


def report(data: Row) -> str:
    tables = (report_times, report_solvers, report_energies, report_guesses)
    return joined(machine_line(data["machine"]), *(table(data) for table in tables))


def mesh_label(row: Row) -> str:
    return f"{row['mesh']}, {row['n_vertices']}" if "n_vertices" in row else str(row["mesh"])


def cell(result: Row, key: str, digits: int = 3) -> str:
    return f"not run: {result['not_run']}" if "not_run" in result else number(result[key], digits)


def report_times(data: Row) -> str:
    headers = ["bind + 200 iterations, s", "report, one thread", "report, OpenMP", "ours, one thread"]
    headers += [f"ours, {data['cores']} threads", "ours, default threads"]
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
        line = [solver, f"{published:.2f}" if published else NOTHING]
        for mesh in meshes:
            found = [row for row in data["solvers"] if row["solver"] == solver and mesh_label(row) == mesh]
            line += [cell(found[0], "total_s"), cell(found[0], "energy", 6)] if found else [NOTHING, NOTHING]
        lines.append(line)
    return markdown(headers, lines)


def report_energies(data: Row) -> str:
    lines = [(mesh_label(row), *(cell(row[move], "energy", 4) for move in MOVES)) for row in data["energies"]]
    names = {row["mesh"] for row in data["energies"]}
    lines += [(name, NOTHING, NOTHING, NOTHING) for name in ENERGY_MESHES if name not in names]
    return markdown(("energy after 200 iterations", *MOVES), lines)


def report_guesses(data: Row) -> str:
    names = {"rest": "rest", "naive_laplacian": "naive Laplacian", "handle_rotations": "handles' rotations"}
    headers = ("energy after 200 iterations, large move", *(names.get(guess, "as in a drag") for guess in GUESSES))
    lines = [(mesh_label(row), *(cell(row[guess], "energy", 5) for guess in GUESSES)) for row in data["guesses"]]
    return markdown(headers, lines)
