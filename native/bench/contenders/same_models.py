# SPDX-License-Identifier: GPL-3.0-or-later
"""A model of ours and the same model of another library, both on a task in one process; see measure.runs.same_models.

    python -m contenders.same_models

Reads a JSON object a line, {"ours": [module, model], "theirs": [module, model], "task": path}, and answers with a
line of JSON:

    version      of the other library
    distance     the largest between both results at the end, as a fraction of the diagonal
    energies     ours and theirs at the end, both as our model measures it; null where it has no energy
    set_up_s     [[ours, theirs]], several
    step_s       [[ours, theirs]] of each step

or {"not_run": reason}. Both go one step after the other, so that a busy moment of the machine does not fall on one.
"""

from __future__ import annotations

import importlib
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from measure.base.contender import Contender, Floats, Make, PosedTask, read_posed

from .worker import serve

SET_UPS = 3
Result = TypeVar("Result")


def compared(makes: Sequence[Make], task: PosedTask) -> dict[str, Any]:
    """Of both: ours, then the other library's."""
    set_up_s = []
    for _ in range(SET_UPS):
        contenders, times = timed([partial(make, task) for make in makes])
        set_up_s.append(times)
    steps = range(task.steps)
    step_s = [timed([partial(contender.pose, step) for contender in contenders])[1] for step in steps]
    away = np.linalg.norm(contenders[0].positions() - contenders[1].positions(), axis=1)
    energy = getattr(contenders[0], "energy", None)
    return {
        "version": contenders[1].version,
        "distance": float(away.max()),
        "energies": [energy(places(contender)) for contender in contenders] if energy else None,
        "set_up_s": set_up_s,
        "step_s": step_s,
    }


def timed(calls: Sequence[Callable[[], Result]]) -> tuple[list[Result], list[float]]:
    """What calls give, and the seconds of each."""
    found, seconds = [], []
    for call in calls:
        start = time.perf_counter()
        found.append(call())
        seconds.append(time.perf_counter() - start)
    return found, seconds


def places(contender: Contender) -> Floats:
    """Of all vertices, where it has more than those of the mesh."""
    inside: Floats | None = getattr(contender, "places", None)
    return contender.positions() if inside is None else inside


def answer(command: dict[str, Any]) -> dict[str, Any]:
    pairs = (command["ours"], command["theirs"])
    makes = [importlib.import_module(f"contenders.{module}").MODELS[model] for module, model in pairs]
    return compared(makes, read_posed(Path(command["task"])))


if __name__ == "__main__":
    serve(answer)
