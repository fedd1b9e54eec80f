# SPDX-License-Identifier: GPL-3.0-or-later
"""Calls arap_native with random meshes and arguments, right and wrong, in any order, and looks at what comes back.

    python tests/attack/fuzz_module.py [--seed 1] [--cases 500 | --minutes 20]

The same seed and number of cases make the same calls. Ends with 1 if it found anything: a position that is not finite,
a failed or cancelled solve that moved the mesh, an error of a wrong type or without a cause in words. A crash ends the
process with the stack of Python. Under a sanitizer, preload its runtime and give the module that was built with it.
"""

from __future__ import annotations

import argparse
import faulthandler
import functools
import random
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import arap_native
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))

import zoo

ERRORS = (ValueError, TypeError, RuntimeError, MemoryError, IndexError, OverflowError)
NOT_WORDS = ("std::", "bad_alloc", "internal error", "vector::")
NAN, INFINITY = float("nan"), float("inf")
FLOATS = [NAN, INFINITY, -INFINITY, 1e300, -1e300, 5e-324, -5e-324, 0.0, -0.0, 1e100, 1e101, -1.0, 1e-300, 1.0, 1e15]
INTEGERS = [-1, 0, 2**31 - 1, -(2**31), 1, 10**9, 7]
NO_ARRAYS = [None, 3, "x", [], [[1, 2, 3]], object(), b"abc", NAN]
# Kinds whose least size is large or whose cost grows fast even if they are small.
TOO_LARGE = {"thirty_hubs", "loose_vertices", "loose_vertices_in_one_place", "loose_vertices_of_all_scales"}
SMALL_KINDS = [name for name in zoo.KINDS if name not in TOO_LARGE]


class Interrupted(Exception):
    """Raised by a progress callback: it has to come back out of the call."""


class Outcome(NamedTuple):
    """What a call gave: a value or an error."""

    value: Any = None
    error: Exception | None = None


class Fuzzer:
    """One stream of random calls, the same for the same seed."""

    def __init__(self, seed: int) -> None:
        self.random = random.Random(seed)
        self.rng = np.random.default_rng(seed)
        self.seed = seed
        self.case = 0
        self.calls: Counter[str] = Counter()
        self.findings: list[str] = []

    def one_case(self) -> None:
        """A mesh, bound, and some calls on it."""
        self.case += 1
        mesh = self.mesh()
        solver = self.bound(mesh, *self.random.choice([self.surface, self.lattice])())
        if solver is not None:
            Session(self, solver).run()

    def surface(self) -> tuple[type[arap_native.Model], Any]:
        return arap_native.SurfaceArap, self.call("Options", self.options).value

    def lattice(self) -> tuple[type[arap_native.Model], Any]:
        return arap_native.LatticeArap, self.call("LatticeOptions", self.lattice_options).value

    def bound(self, mesh: zoo.Mesh, model: Any, options: Any) -> arap_native.Model | None:
        n = len(mesh.positions)
        keywords: dict[str, Any] = {}
        if self.chance(0.3):
            decades = 300 if self.chance(0.1) else 3
            keywords["stiffness"] = self.maybe_wrong(10 ** self.rng.uniform(-decades, decades, n))
        if self.chance(0.3):
            keywords["rigid_regions"] = self.maybe_wrong(self.rng.integers(-2, 3, n).astype(np.int32))
        if self.chance(0.2):
            keywords["progress"] = self.progress()
        arrays = (self.maybe_wrong(array) for array in mesh)
        return self.call(model.__name__, model, *arrays, options=options, **keywords).value

    # --------------------------------------------------------------------------------------------- random things

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def mesh(self) -> zoo.Mesh:
        name = self.random.choice(SMALL_KINDS)
        size = self.random.choice([3, 5, 10, 40, 200, 900]) if self.chance(0.9) else 3000
        return zoo.KINDS[name](max(8, size), self.rng)

    def options(self) -> arap_native.Options:
        choices: dict[str, list[Any]] = {
            "energy": ["rotation_nodes", "spokes_and_rims", "spokes"],
            "rigidity_radius": [0.02, 0.5, 1, 1e-6, 0.1],
            "weights": ["cotangent", "uniform"],
            "threads": [0, 1, 2, 3, 7],
            "join_seams": [True, False],
        }
        wrong = {"energy": ["x", 3, None], "rigidity_radius": [0, -1, NAN, 2, 1e300], "threads": [-1, 2**31, "a", 1.5]}
        return arap_native.Options(**self.some(choices, wrong))

    def lattice_options(self) -> arap_native.LatticeOptions:
        choices: dict[str, list[Any]] = {
            "cube_size": [0, 0.05, 0.2, 1],
            "keep_volume": [0, 0.5, 1],
            "threads": [0, 1, 2, 3, 7],
            "join_seams": [True, False],
        }
        wrong = {"cube_size": [-1, NAN, 2, 1e-9], "keep_volume": [-1, NAN, 1.5, 1e300], "threads": [-1, "a"]}
        return arap_native.LatticeOptions(**self.some(choices, wrong))

    def solve_options(self) -> arap_native.SolveOptions:
        choices: dict[str, list[Any]] = {
            "initial_guess": ["previous", "rest", "naive_laplacian", "handle_rotations"],
            "acceleration": ["conjugate_gradients", "none"],
            "accuracy": [0, 1e-12, 1e-7, 1e-6, 1e-3, 1, 5e-324],
            "time_limit_s": [1e-9, 1e-3, 0.1, INFINITY],
        }
        wrong = {"accuracy": [-1, NAN, INFINITY], "time_limit_s": [0, -1, NAN], "initial_guess": ["y"]}
        return arap_native.SolveOptions(
            max_iterations=self.random.choice([1, 2, 3, 10, 50]), **self.some(choices, wrong)
        )

    def some(self, choices: dict[str, list[Any]], wrong: dict[str, list[Any]]) -> dict[str, Any]:
        """Some of the keywords, with a value each, seldom a wrong one."""
        chosen = {name: self.random.choice(values) for name, values in choices.items() if self.chance(0.4)}
        if self.chance(0.05):
            name = self.random.choice(list(wrong))
            chosen[name] = self.random.choice(wrong[name])
        return chosen

    def progress(self) -> Callable[[float], Any]:
        """A callback that goes on, stops, raises, or answers nonsense, at once or later."""
        left = self.random.randint(0, 20)
        kind = self.random.choice(["stop", "raise", "nonsense", "go on"])

        def told(done: float) -> Any:
            nonlocal left
            if not 0 <= done <= 1:
                self.found(f"progress of {done}")
            left -= 1
            if left > 0 or kind == "go on":
                return self.random.choice([None, 1, "", [], {}, 0.0, "x"]) if kind == "nonsense" else None
            if kind == "raise":
                raise Interrupted
            return False

        return told

    def maybe_wrong(self, array: np.ndarray) -> Any:
        return self.wrong(array) if self.chance(0.08) else array

    def wrong(self, array: np.ndarray) -> Any:
        """Something near the array that is not right, or is right but unusual."""
        changes: list[Callable[[], Any]] = [
            lambda: self.random.choice(NO_ARRAYS),
            lambda: array.astype(
                self.random.choice(["f4", "f8", "i4", "i8", "u4", ">f8", ">i4", "c16", "?", "i1", "O"])
            ),
            lambda: array[..., ::-1],
            lambda: array[::2],
            lambda: array[::-1],
            lambda: np.asfortranarray(array),
            lambda: read_only(array),
            lambda: array[:0],
            lambda: np.array(array.flat[0] if array.size else 0, dtype=array.dtype),
            lambda: self.with_odd_entries(array),
            lambda: np.broadcast_to(array, (3, *array.shape)),
            lambda: array.reshape(-1),
            lambda: np.concatenate([array, array]),
            lambda: list(array),
            lambda: np.ma.masked_array(array),
            lambda: unaligned(array),
            lambda: np.broadcast_to(array[:1], array.shape) if len(array) else array,
        ]
        with np.errstate(all="ignore"):
            return self.random.choice(changes)()

    def with_odd_entries(self, array: np.ndarray) -> np.ndarray:
        changed = array.copy()
        odd = FLOATS if array.dtype.kind == "f" else INTEGERS
        for _ in range(self.random.randint(1, 3) if array.size else 0):
            changed.flat[self.random.randrange(array.size)] = self.random.choice(odd)
        return changed

    # --------------------------------------------------------------------------------------------- calls

    def call(self, name: str, function: Callable[..., Any], *arguments: Any, **keywords: Any) -> Outcome:
        """Calls, and looks at the error if there is one."""
        self.calls[name] += 1
        try:
            return Outcome(value=function(*arguments, **keywords))
        except Interrupted as error:
            return Outcome(error=error)
        except ERRORS as error:
            self.calls[f"{name}: {type(error).__name__}"] += 1
            if not 0 < len(str(error)) < 300 or any(word in str(error) for word in NOT_WORDS):
                self.found(f"{name} says {error!r}")
            return Outcome(error=error)

    def found(self, what: str) -> None:
        self.findings.append(what)
        print(f"FOUND in case {self.case} of seed {self.seed}: {what}", flush=True)


class Session:
    """Random calls on one bound mesh."""

    def __init__(self, fuzzer: Fuzzer, solver: Any) -> None:
        self.fuzzer = fuzzer
        self.random, self.rng = fuzzer.random, fuzzer.rng
        self.solver = solver
        self.n = solver.n_vertices
        self.vertices = np.zeros(0, np.int32)
        self.n_patches = 0
        self.segments: np.ndarray | None = None
        self.before = solver.positions

    def run(self) -> None:
        repr(self.solver)
        acts = [self.set_constraints] * 3 + [self.solve] * 5 + [self.solve_in_job] * 2
        acts += [self.start_elsewhere]
        if isinstance(self.solver, arap_native.SurfaceArap):
            acts += [self.energy, self.patch_around, self.patches_in_job]
        else:
            acts += [self.bones_outside, self.cube_corners]
        for act in (self.set_constraints, *(self.random.choice(acts) for _ in range(self.random.randint(1, 8)))):
            self.before = self.solver.positions
            if not np.isfinite(self.before).all():
                self.fuzzer.found("the solver's positions are not finite")
                return
            act()

    def set_constraints(self) -> None:
        count = self.random.randint(0, min(self.n, 8))
        vertices = self.rng.choice(self.n, count, replace=False).astype(np.int32)
        strengths = self.random.choice(
            [np.ones(count), self.rng.uniform(0.01, 1, count), 10 ** self.rng.uniform(-15, 0, count)]
        )
        patches, n_patches = self.patches() if self.fuzzer.chance(0.4) else (None, 0)
        wrong = self.fuzzer.maybe_wrong
        segments = self.some_segments() if self.fuzzer.chance(0.4) else None
        arguments = (wrong(vertices), wrong(strengths), patches, None if segments is None else wrong(segments))
        outcome = self.fuzzer.call("set_constraints", self.solver.set_constraints, *arguments, progress=self.progress())
        if outcome.error is None:
            self.vertices, self.n_patches, self.segments = vertices, n_patches, segments

    def some_segments(self) -> np.ndarray:
        """From a vertex to another one, or beyond."""
        ends = self.before[self.rng.integers(0, self.n, (self.random.randint(1, 3), 2))]
        return ends * self.random.choice([1, 1, 1, 0.9, 3, 1e6])

    def bones_outside(self) -> None:
        self.fuzzer.call(
            "segments_outside", self.solver.segments_outside, self.fuzzer.maybe_wrong(self.some_segments())
        )

    def cube_corners(self) -> None:
        corners = self.fuzzer.call("cube_corners", self.solver.cube_corners).value
        if corners is not None and not np.isfinite(corners).all():
            self.fuzzer.found("corners of cubes are not finite")

    def targets_at_rest(self) -> np.ndarray:
        """Nearly, and of patches anywhere."""
        rows = [self.before[self.vertices], self.rng.normal(size=(self.n_patches, 3))]
        for head, tail in () if self.segments is None else self.segments:
            rows += [head[None], head + np.linalg.norm(tail - head) * np.eye(3)]
        return np.concatenate(rows)

    def patches(self) -> tuple[tuple[Any, ...], int]:
        sizes = self.rng.integers(1, 6, self.random.randint(1, 3))
        offsets = np.concatenate([[0], np.cumsum(sizes)]).astype(np.int32)
        members = self.rng.integers(0, self.n, offsets[-1]).astype(np.int32)
        arrays = (offsets, members, self.rng.uniform(0, 1, offsets[-1]))
        return tuple(self.fuzzer.maybe_wrong(array) for array in arrays), len(sizes)

    def solve(self) -> None:
        targets = self.targets_at_rest()
        rows = len(targets)
        targets = targets + self.rng.normal(size=targets.shape) * self.random.choice(
            [0, 1e-3, 1, 10, 1e6, 1e30, 1e90, 1e-30]
        )
        wrong = self.fuzzer.maybe_wrong
        keywords: dict[str, Any] = {"progress": self.progress()}
        if self.fuzzer.chance(0.2):
            keywords["rotations"] = wrong(
                self.rng.normal(size=(rows, 3, 3)) * self.random.choice([1, 0, 1e200, 1e-200])
            )
        if self.fuzzer.chance(0.4):
            keywords["out"] = wrong(np.zeros((self.n, 3), np.float32))
        options = self.fuzzer.call("SolveOptions", self.fuzzer.solve_options).value
        outcome = self.fuzzer.call("solve", self.solver.solve, wrong(targets), options, **keywords)
        if outcome.value is None:
            self.expect_unmoved("failed")
        else:
            self.look_at(outcome.value, options)

    def look_at(self, result: arap_native.SolveResult, options: arap_native.SolveOptions | None) -> None:
        """``out`` is float32, so it holds infinity for what float64 still can say."""
        is_huge = np.abs(self.solver.positions).max() > 1e38
        if not np.isfinite(result.positions).all() and not (result.positions.dtype == np.float32 and is_huge):
            self.fuzzer.found(f"positions of {result!r} are not finite")
        if not np.isfinite([result.energy_before, result.energy_after, result.step]).all():
            self.fuzzer.found(f"numbers of {result!r} are not finite")
        if result.stop_reason == "cancelled":
            self.expect_unmoved("cancelled")
        if not 0 <= result.iterations <= (options.max_iterations if options else 1000):
            self.fuzzer.found(f"iterations of {result!r}")

    def expect_unmoved(self, what: str) -> None:
        if not np.array_equal(self.before, self.solver.positions):
            self.fuzzer.found(f"a {what} solve moved the mesh")

    def energy(self) -> None:
        scale = self.random.choice([0, 1, 1e10, 1e99])
        positions = self.before + self.rng.normal(size=self.before.shape) * scale
        self.fuzzer.call("energy", self.solver.energy, self.fuzzer.maybe_wrong(positions))
        gradient = self.fuzzer.call("energy_gradient", self.solver.energy_gradient, positions).value
        if gradient is not None and not np.isfinite(gradient).all():
            self.fuzzer.found(f"the gradient is not finite at positions of up to {np.abs(positions).max():g}")

    def start_elsewhere(self) -> None:
        if self.fuzzer.chance(0.5):
            self.fuzzer.call("reset", self.solver.reset)
        else:
            moved = self.before + self.rng.normal(size=self.before.shape) * self.random.choice([0, 1, 1e10, 1e90])
            self.fuzzer.call("set_positions", self.solver.set_positions, self.fuzzer.maybe_wrong(moved))

    def solve_in_job(self) -> None:
        targets = self.targets_at_rest()
        options = self.fuzzer.call("SolveOptions", self.fuzzer.solve_options).value
        out = self.fuzzer.maybe_wrong(np.zeros((self.n, 3), np.float32)) if self.fuzzer.chance(0.4) else None
        begin = functools.partial(self.solver.begin_solve, out=out)
        result = self.outcome_of_job("begin_solve", begin, self.fuzzer.maybe_wrong(targets), options)
        if result is not None:
            self.look_at(result, options)

    def patches_in_job(self) -> None:
        groups = [self.rng.integers(0, self.n, self.random.randint(0, 4)).astype(np.int32) for _ in range(3)]
        radii = np.array([self.random.choice([0, 0.1, 10, NAN]) for _ in groups])
        groups[0] = self.fuzzer.maybe_wrong(groups[0])
        self.outcome_of_job("begin_patches", self.solver.begin_patches, groups, self.fuzzer.maybe_wrong(radii))

    def outcome_of_job(self, name: str, begin: Callable[..., Any], *arguments: Any) -> Any:
        """Begins a job, and cancels it or not; its result, None if there is none."""
        job = self.fuzzer.call(name, begin, *arguments).value
        if job is None:
            return None
        if self.fuzzer.chance(0.3):
            self.fuzzer.call("wait", job.wait, self.random.choice([0.0, 1e-4, -1.0, NAN]))
            self.fuzzer.call("reset", self.solver.reset)  # is refused if the job is under way
            job.cancel()
        return self.fuzzer.call("result", job.result).value

    def patch_around(self) -> None:
        vertices = self.rng.integers(0, self.n, self.random.randint(0, 4)).astype(np.int32)
        radius = self.random.choice([0, 0.1, 1, 10, 1e-9, NAN, INFINITY, -1, 1e300])
        patch = self.fuzzer.call(
            "patch_around", self.solver.patch_around, self.fuzzer.maybe_wrong(vertices), radius
        ).value
        if patch is not None and not (np.isfinite(patch[2]).all() and abs(patch[1].sum() - 1) < 1e-9):
            self.fuzzer.found(f"patch_around gives {patch}")

    def progress(self) -> Callable[[float], Any] | None:
        return self.fuzzer.progress() if self.fuzzer.chance(0.2) else None


def read_only(array: np.ndarray) -> np.ndarray:
    copy = array.copy()
    copy.flags.writeable = False
    return copy


def unaligned(array: np.ndarray) -> np.ndarray:
    shifted = np.frombuffer(bytearray(array.nbytes + 1), dtype=array.dtype, offset=1, count=array.size)
    shifted = shifted.reshape(array.shape)
    shifted[...] = array
    return shifted


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, default=500, help="meshes; without --minutes")
    parser.add_argument("--minutes", type=float, help="in place of a number of cases")
    args = parser.parse_args()
    faulthandler.enable()
    fuzzer = Fuzzer(args.seed)
    end = time.monotonic() + 60 * args.minutes if args.minutes else None
    while time.monotonic() < end if end else fuzzer.case < args.cases:
        fuzzer.one_case()
    for name, count in sorted(fuzzer.calls.items()):
        print(f"{count:8}  {name}")
    print(f"seed {args.seed}: {fuzzer.case} meshes, {len(fuzzer.findings)} findings")
    return 1 if fuzzer.findings else 0


if __name__ == "__main__":
    sys.exit(main())
