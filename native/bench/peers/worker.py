# SPDX-License-Identifier: GPL-3.0-or-later
"""One library on one task file, in a process of its own; measure.runs.peers says what when.

    python -m peers.worker LIBRARY TASK POSITIONS OPTIONS

LIBRARY is ours, libigl or open3d; OPTIONS a JSON object with "energy" (spokes or spokes_and_rims) and what else the
library takes. Reads commands, one a line, and answers each with one line of JSON; times are in milliseconds.
peers/cgal_peer.cpp does the same for CGAL.

    version   {"version"}
    bind      {"ms"}            all that does not depend on the targets, from the library's own kind of mesh on
    solve K   {"ms"}            K iterations from rest, bind not counted; the result goes to POSITIONS, (n, 3) float64
    memory    {"peak_mb"}       most memory that was resident up to now
"""

from __future__ import annotations

import importlib
import json
import sys
import time
from pathlib import Path
from statistics import median
from typing import Any, Protocol

import numpy as np
from measure.base.machine import process_memory
from measure.inputs.mesh import Mesh
from measure.inputs.tasks import Task, read_task
from numpy.typing import NDArray


class Library(Protocol):
    """One library, made for a mesh of triangles and a task.

    Attributes:
        binds_in_every_solve: it has no bind of its own: solve() does one, as long as bind() takes.
    """

    version: str
    binds_in_every_solve: bool

    def __init__(self, mesh: Mesh, task: Task, options: dict[str, Any]) -> None: ...
    def bind(self) -> None: ...
    def solve(self, n_iterations: int) -> None:
        """Exactly so many iterations from rest."""

    def positions(self) -> NDArray[np.float64]:
        """(n, 3) float64, C-ordered, where the last solve ended."""


class Measured:
    """A library and the times of its binds."""

    def __init__(self, library: Library, positions: Path) -> None:
        self._library, self._positions = library, positions
        self._bind_ms: list[float] = []

    def answer(self, command: str) -> dict[str, object]:
        name, _, number = command.strip().partition(" ")
        if name == "version":
            return {"version": self._library.version}
        if name == "bind":
            return {"ms": self._bind()}
        if name == "solve":
            return self._solve(int(number))
        if name == "memory":
            return {"peak_mb": 1e-6 * process_memory("VmHWM")}
        raise ValueError(f"no command {name}")

    def _bind(self) -> float:
        start = time.perf_counter()
        self._library.bind()
        self._bind_ms.append(1e3 * (time.perf_counter() - start))
        return self._bind_ms[-1]

    def _solve(self, n_iterations: int) -> dict[str, object]:
        start = time.perf_counter()
        self._library.solve(n_iterations)
        ms = 1e3 * (time.perf_counter() - start)
        self._library.positions().tofile(self._positions)
        bind_ms = median(self._bind_ms) if self._library.binds_in_every_solve else 0.0
        return {"ms": ms - bind_ms}


def main() -> None:
    name, task_path, positions, options = sys.argv[1:]
    mesh, task = read_task(Path(task_path))
    library: Library = importlib.import_module(f"peers.{name}_peer").Peer(mesh, task, json.loads(options))
    measured = Measured(library, Path(positions))
    for command in sys.stdin:
        print(json.dumps(measured.answer(command)), flush=True)


if __name__ == "__main__":
    main()
