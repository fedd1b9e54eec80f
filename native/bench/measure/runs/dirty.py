# SPDX-License-Identifier: GPL-3.0-or-later
"""How many of twenty kinds of dirty meshes a model binds and poses: those of the tests that attack the module."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import zoo

from ..base.contender import PosedTask, write_posed
from ..base.progress import say
from ..base.workers import Ended, NotRun
from .contenders import Entry, Process

N_VERTICES = 400
HELD, MOVED, SHIFT = 0.1, 0.05, 0.1  # shares of the vertices along the longest axis, and of its length
TIMEOUT_S = 20.0
KINDS = (
    "needles", "caps", "collapsed_rows", "all_scales", "tiny", "huge", "far_from_the_origin", "exploded_vertex",
    "half_cluster", "loose_vertices", "triangles_apart", "two_walls_in_one_place", "crumpled", "open_seams",
    "random_orientation", "moebius_strip", "faces_twenty_times", "faces_with_repeated_corners", "touching_at_a_vertex",
    "fan_on_an_edge",
)  # fmt: skip


def dirty_task(kind: str) -> PosedTask:
    """The lowest vertices along the longest axis held, the highest moved along it."""
    mesh = zoo.KINDS[kind](N_VERTICES, np.random.default_rng(1))
    n, axis = len(mesh.positions), int(np.argmax(np.ptp(mesh.positions, axis=0)))
    order = np.argsort(mesh.positions[:, axis], kind="stable").astype(np.int32)
    held, moved = order[: round(HELD * n)], order[n - round(MOVED * n) :]
    targets = mesh.positions[np.concatenate([held, moved])]
    targets[len(held) :, axis] += SHIFT * np.ptp(mesh.positions[:, axis])
    return PosedTask(mesh.positions, mesh.corners, mesh.sizes, held, moved, targets[None], np.eye(3)[None])


def measure_dirty(models: Sequence[Entry], folder: Path, known: dict[str, Any]) -> dict[str, Any]:
    """For each model the number of kinds, how many it posed so that all is finite, and why not the others."""
    paths = {kind: folder / f"{kind}.npz" for kind in KINDS}
    for kind, path in paths.items():
        write_posed(path, dirty_task(kind))
    for entry in models:
        if entry.not_run:
            known[entry.name] = {"not_run": entry.not_run}
            continue
        failed = failures(entry, folder, paths)
        known[entry.name] = {"n_meshes": len(KINDS), "n_bound": len(KINDS) - len(failed), "failed": failed}
        say(f"dirty, {entry.name}", known[entry.name])
    return known


def failures(entry: Entry, folder: Path, paths: dict[str, Path]) -> dict[str, str]:
    """The kinds that the model did not pose, each with the reason; a new process where one has ended."""
    found: dict[str, str] = {}
    left = list(paths)
    while left:
        with Process(entry, folder, TIMEOUT_S) as process:
            left = pose_until_it_ends(process, left, paths, found)
    return found


def pose_until_it_ends(process: Process, kinds: list[str], paths: dict[str, Path], found: dict[str, str]) -> list[str]:
    """Adds why kinds were not posed to ``found``; the kinds that are left when the process has ended."""
    for k, kind in enumerate(kinds):
        try:
            process.run(paths[kind])
        except Ended as reason:
            found[kind] = str(reason)
            return kinds[k + 1 :]
        except NotRun as reason:
            found[kind] = str(reason)
    return []
