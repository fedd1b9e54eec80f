# SPDX-License-Identifier: GPL-3.0-or-later
"""What the measurements of a frame share: the sample creature with pins and handles, and a stopwatch for its steps."""

from __future__ import annotations

import contextlib
import importlib
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "blend_files"))

PINS = ("Paw front L", "Paw front R", "Paw hind L", "Paw hind R")
DRAGS = {  # handle: shift in metres at the end of the drag, turn about z in radians
    "Head": ((0.15, -0.10, 0.10), 0.5),
    "Tail": ((-0.20, 0.05, 0.25), -0.8),
    "Ear L": ((0.05, 0.05, -0.05), 0.4),
    "Ear R": ((-0.05, 0.05, -0.05), -0.4),
}

Milliseconds = dict[str, list[float]]


class Stopwatch:
    """Times calls of functions within a frame."""

    def __init__(self) -> None:
        self.rows: Milliseconds = defaultdict(list)
        self._frame: dict[str, float] = {}
        self._running: set[str] = set()

    @contextlib.contextmanager
    def step(self, name: str) -> Iterator[None]:
        """Adds to a step of the frame; within itself it counts once."""
        if name in self._running:
            yield
            return
        self._running.add(name)
        start = time.perf_counter()
        try:
            yield
        finally:
            self._running.remove(name)
            self._frame[name] = self._frame.get(name, 0.0) + 1e3 * (time.perf_counter() - start)

    def watch(self, owner: object, function: str, name: str) -> None:
        """Times every call of ``owner.function`` from now on."""
        original = getattr(owner, function)

        def timed(*arguments: object, **keywords: object) -> object:
            with self.step(name):
                return original(*arguments, **keywords)

        setattr(owner, function, timed)

    def watch_session(self, package: str, session) -> None:
        """Times what every frame does, whichever act asks for it: "solve" and so on."""
        session._model = NativeProxy(session._model)
        self.watch(importlib.import_module(f"{package}.scene.handle_motion"), "motions", "read handles")
        self.watch(session._map, "targets", "map to targets")
        self.watch(session._model, "solve", "solve")
        self.watch(session, "_show_solved", "convert")
        self.watch(importlib.import_module(f"{package}.scene.shape_keys"), "write", "write key")

    def has(self, name: str) -> bool:
        """Whether the frame has this step by now."""
        return name in self._frame

    def take(self) -> dict[str, float]:
        """The steps of the frame that ends here, in ms."""
        done, self._frame = self._frame, {}
        return done

    @contextlib.contextmanager
    def frame(self, *, outside: tuple[str, ...], rest: str, total: str) -> Iterator[None]:
        """One frame: the steps add up to ``total``, with the untimed part in ``rest``."""
        self._frame = {}
        start = time.perf_counter()
        yield
        whole = 1e3 * (time.perf_counter() - start)
        steps = self.take()
        inside = sum(ms for name, ms in steps.items() if name not in outside)
        for name, ms in steps.items():
            self.rows[name].append(ms)
        self.rows[rest].append(whole - inside - sum(steps.get(name, 0.0) for name in outside))
        self.rows[total].append(whole)


class NativeProxy:
    """Stands for a SurfaceArap, whose own attributes cannot be set, so that its calls can be timed."""

    def __init__(self, solver: object) -> None:
        self._solver = solver

    def solve(self, *arguments: object, **keywords: object) -> object:
        return self._solver.solve(*arguments, **keywords)

    def __getattr__(self, name: str) -> object:
        return getattr(self._solver, name)


def creature_object(n_vertices: int):
    """The creature with about so many vertices, linked to the scene; and the vertices of its pins and handles."""
    import bpy
    from scenes.blender_scene import quads_mesh
    from scenes.creature import creature, creature_groups

    model = creature(n_vertices)
    obj = bpy.data.objects.new("Creature", quads_mesh("Creature", model.positions, model.quads))
    bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return obj, creature_groups(model)


def summary(rows: Milliseconds) -> dict[str, dict[str, float]]:
    """Best and median of each row."""
    return {name: {"best": min(times), "median": median(times)} for name, times in rows.items()}


def median(values: list[float]) -> float:
    return sorted(values)[len(values) // 2]
