# SPDX-License-Identifier: GPL-3.0-or-later
"""The models of one module, in a process of its own; measure.runs.contenders says what when.

    python -m contenders.worker MODULE

MODULE is a file of this folder without .py. Reads commands, one a line, a JSON object each, and answers with a line of
JSON:

    {}                                          {"models": {name: what it is given, as a sentence}}
    {"model": name, "task": path, "out": path, "limit_s": seconds}
                                                {"version", "acts", "set_up_s", "step_s": of each step, "peak_mb"}

The task is what measure.base.contender.write_posed wrote; the result goes to ``out``, an .npz with positions (n, 3).
peak_mb is the memory, in 10^6 bytes, that was resident at most beyond what was before the set-up. A task of which the
first steps say that it will take much longer than the limit is given up. Where a model cannot
do a task, or fails, the answer is {"not_run": reason}. What libraries print goes nowhere.
"""

from __future__ import annotations

import gc
import importlib
import json
import os
import resource
import sys
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import gettempdir
from typing import Any

import numpy as np
from measure.base.contender import Make, read_posed
from measure.base.machine import process_memory
from measure.base.workers import NotRun

SLOWER = 1.5  # first steps may be slower than the others
MOST_MEMORY = 12 << 30  # bytes of address space: the machine goes on where a model wants too much


def run(make: Make, task_path: str, out: str, limit_s: float) -> dict[str, Any]:
    """A task from rest through all its steps."""
    task = read_posed(Path(task_path))
    gc.collect()
    Path("/proc/self/clear_refs").write_text("5")  # the peak starts here
    before = process_memory("VmRSS")
    start = time.perf_counter()
    contender = make(task)
    set_up_s = time.perf_counter() - start
    step_s = []
    for step in range(task.steps):
        start = time.perf_counter()
        contender.pose(step)
        step_s.append(time.perf_counter() - start)
        if set_up_s + sum(step_s) * task.steps / (step + 1) > SLOWER * limit_s:
            raise NotRun(f"would take longer than {limit_s:g} s")
    peak = process_memory("VmHWM") - before
    positions = np.asarray(contender.positions(), dtype=np.float64)
    if positions.shape != task.positions.shape or not np.isfinite(positions).all():
        raise NotRun("gives positions that are not finite, or not those of all vertices")
    np.savez(out, positions=positions)
    return {
        "version": contender.version,
        "acts": list(contender.acts),
        "set_up_s": set_up_s,
        "step_s": step_s,
        "peak_mb": 1e-6 * peak,
    }


def answer(module: Any, command: dict[str, Any]) -> dict[str, Any]:
    if not command:
        return {"models": {model: module.INPUTS[model] for model in module.MODELS}}
    return run(module.MODELS[command["model"]], command["task"], command["out"], command["limit_s"])


def serve(do: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    """Answers commands until there are no more; why one fails is its answer."""
    os.chdir(gettempdir())  # some libraries leave files where they are
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY, MOST_MEMORY))
    for line in sys.stdin:
        try:
            said = do(json.loads(line))
        except NotRun as reason:
            said = {"not_run": str(reason)}
        except Exception as error:  # noqa: BLE001  a library may raise anything, and the next task still runs
            said = {"not_run": f"{type(error).__name__}: {error}".splitlines()[0]}
        print(json.dumps(said), file=answers, flush=True)
    sys.stdout.flush()
    os._exit(0)  # some libraries crash, or print thousands of lines, at their exit


def main() -> None:
    module = importlib.import_module(f"contenders.{sys.argv[1]}")
    serve(lambda command: answer(module, command))


if __name__ == "__main__":
    main()
