# SPDX-License-Identifier: GPL-3.0-or-later
"""Who takes part in the comparison, and a task done by one of them, in a process of its own."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from statistics import median
from types import TracebackType
from typing import Any, NamedTuple, final

import numpy as np

from ..base.installed import ROOT, blender_python, cgal_library, library_python
from ..base.workers import NotRun, Worker
from ..inputs.mesh import Floats

PATH = (ROOT / "native/bench", ROOT / "blend_files", ROOT / "addon")  # all that a contender imports from here
START_S = 120.0  # to import a library


class Library(NamedTuple):
    """Modules of ``contenders``, and the Python that has what they need; it is set up when it is asked for."""

    modules: tuple[str, ...]
    python: Callable[[], Path]


def this_python() -> Path:
    return Path(sys.executable)


def with_cgal() -> Path:
    cgal_library()
    return this_python()


# By what stands before the colon in the names of their models; ours have none.
LIBRARIES: dict[str, Library] = {
    "": Library(("ours", "ours_inside", "ours_cages"), this_python),
    "libigl": Library(("libigl",), lambda: library_python("libigl")),
    "CGAL": Library(("cgal",), with_cgal),
    "Open3D": Library(("open3d",), lambda: library_python("open3d", "peers")),
    "Blender": Library(("blender",), blender_python),
}


class Entry(NamedTuple):
    """A model, what starts the process that runs it, and what it is given; or why its library does not run here."""

    name: str
    command: tuple[str, ...] = ()
    given: str = ""
    not_run: str = ""


def entries(wanted: Sequence[str]) -> Iterator[Entry]:
    """The models of these names, all where there are none. Libraries of which none is wanted are not set up.

    Raises:
        ValueError: no model has a name.
    """
    known: list[str] = []
    for name, library in LIBRARIES.items():
        if wanted and name not in map(library_of, wanted):
            continue
        for module in library.modules:
            try:
                command = (str(library.python()), "-m", "contenders.worker", module)
                models = models_of(command)
            except NotRun as reason:
                yield Entry(f"{name}: all of {module}" if name else module, not_run=str(reason))
                continue
            known += models
            yield from (
                Entry(model, command, given) for model, given in models.items() if not wanted or model in wanted
            )
    unknown = [model for model in wanted if model not in known]
    if unknown:
        raise ValueError(f"no model is named {'; '.join(unknown)}. The names are {'; '.join(known)}")


def library_of(model: str) -> str:
    library, colon, _ = model.partition(":")
    return library if colon else ""


def models_of(command: Sequence[str]) -> dict[str, str]:
    """The models of a module, and what each is given."""
    with Worker(command, environment(), START_S) as worker:
        return dict(worker.ask("{}")["models"])


def environment() -> dict[str, str]:
    return {"PYTHONPATH": os.pathsep.join(map(str, PATH))}


class Reached(NamedTuple):
    """Where a task ended, (n, 3), and what the worker said: see contenders/worker.py."""

    positions: Floats
    said: dict[str, Any]

    def costs(self) -> dict[str, Any]:
        """Seconds of the set-up, of the median step and of the last one; memory; version; acts."""
        steps = self.said["step_s"]
        kept = {key: self.said[key] for key in ("version", "acts", "set_up_s", "peak_mb")}
        return {**kept, "median_s": median(steps), "frame_s": steps[-1]}


@final
class Process:
    """A model in a process of its own; leaving the context ends it.

    Raises:
        NotRun: its library does not run here.
    """

    def __init__(self, entry: Entry, folder: Path, timeout_s: float) -> None:
        if entry.not_run:
            raise NotRun(entry.not_run)
        self._model, self._out, self._timeout_s = entry.name, folder / "out.npz", timeout_s
        self._worker = Worker(entry.command, environment(), START_S)

    def __enter__(self) -> Process:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self._worker.__exit__(kind, error, at)

    def run(self, task: Path, timeout_s: float | None = None) -> Reached:
        """The task of a file of write_posed, in a time of its own if it has one.

        Raises:
            NotRun: it cannot do it, failed, or took too long.
        """
        self._worker.ask("{}")  # the time to import its library is not the task's
        limit_s = timeout_s or self._timeout_s
        command = {"model": self._model, "task": str(task), "out": str(self._out), "limit_s": limit_s}
        said = self._worker.ask(json.dumps(command), limit_s, what="the task")
        if "not_run" in said:
            raise NotRun(said["not_run"])
        with np.load(self._out) as data:
            return Reached(data["positions"], said)
