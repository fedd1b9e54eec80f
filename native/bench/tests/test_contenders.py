# SPDX-License-Identifier: GPL-3.0-or-later
"""The models behind one shape: what a task keeps in its file, and the process that runs a model."""

import json
import os
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from contenders import ours, ours_cages, ours_inside
from measure.base.contender import Bones, PosedTask, read_posed, write_posed
from measure.base.workers import Worker
from measure.inputs.bones import Bone, still
from measure.inputs.compared import Compared
from measure.inputs.mesh import make_mesh
from measure.inputs.poses import Pose, View, X, Z, turned
from measure.inputs.solids import rod
from measure.runs.posed import posed_task
from measure.runs.rows import shape_row

BENCH = Path(__file__).resolve().parents[1]
FAULTY = """
import time, numpy as np
from measure.base.workers import NotRun
class Faulty:
    version, acts = "1", ()
    def __init__(self, task): self._rest = task.positions
    def pose(self, step): print("chatter")
    def positions(self): return self._rest + np.nan
class Picky:
    def __init__(self, task): raise NotRun("the mesh is too small")
class Slow(Picky):
    version, acts = "1", ()
    def __init__(self, task): pass
    def pose(self, step): time.sleep(0.2)
class Broken:
    def __init__(self, task): raise ValueError("first\\nsecond")
MODELS = {"faulty": Faulty, "picky": Picky, "broken": Broken, "slow": Slow}
INPUTS = dict.fromkeys(MODELS, "Targets.")
"""


def tetrahedron(steps=2):
    """A polygon soup of four triangles, vertices 0 and 1 held, 2 and 3 moved up."""
    positions = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], dtype=np.int32)
    held, moved = np.array([0, 1], dtype=np.int32), np.array([2, 3], dtype=np.int32)
    targets = np.stack(
        [np.concatenate([positions[:2], positions[2:] + np.array([0, 0, 0.1 * k])]) for k in range(steps)]
    )
    sizes = np.full(4, 3, dtype=np.int32)
    turns = np.tile(np.eye(3), (steps, 1, 1))
    return PosedTask(positions, faces.ravel(), sizes, held, moved, targets, turns)


def test_a_task_comes_back_from_its_file(tmp_path):
    bare = tetrahedron()
    bones = Bones(np.zeros((1, 2, 3)), np.tile(np.eye(3), (2, 1, 1, 1)), np.ones((2, 1, 3)))
    for task in (bare, bare._replace(patch_weights=np.array([0.5, 0.5])), bare._replace(bones=bones)):
        write_posed(tmp_path / "task.npz", task)
        again = read_posed(tmp_path / "task.npz")
        assert (again.patch_weights is None, again.bones is None) == (task.patch_weights is None, task.bones is None)
        np.testing.assert_equal(list(again), list(task))


def test_polygons_are_cut_as_fans():
    task = tetrahedron()._replace(
        corner_vertices=np.array([0, 1, 2, 3, 3, 2, 1, 0, 1], dtype=np.int32),
        face_sizes=np.array([4, 3, 2], dtype=np.int32),
    )
    np.testing.assert_array_equal(task.triangles, [[0, 1, 2], [0, 2, 3], [3, 2, 1]])


def test_a_bone_takes_points_along():
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    bones = Bones(np.array([[[1.0, 0, 0], [2, 0, 0]]]), turn[None, None], np.array([[[5.0, 0, 0]]]))
    np.testing.assert_allclose(bones.moved(0, 0, np.array([[1.0, 0, 0], [2, 0, 0]])), [[5, 0, 0], [5, 1, 0]])


@pytest.fixture
def ask(tmp_path):
    """Asks a new process for the answer of a module, a model and a task."""
    package = tmp_path / "contenders"
    package.mkdir()
    (package / "__init__.py").write_text(f"__path__.append({str(BENCH / 'contenders')!r})")
    (package / "faulty.py").write_text(FAULTY)
    write_posed(tmp_path / "task.npz", tetrahedron())
    paths = [str(tmp_path), *map(os.path.abspath, sys.path)]

    def asked(module, **command):
        with Worker(
            [sys.executable, "-m", "contenders.worker", module], {"PYTHONPATH": os.pathsep.join(paths)}
        ) as worker:
            return worker.ask(json.dumps(command))

    return asked


def test_a_module_says_its_models_and_what_they_are_given(ask):
    assert ask("faulty") == {"models": dict.fromkeys(["faulty", "picky", "broken", "slow"], "Targets.")}


@pytest.mark.parametrize(
    ("model", "limit_s", "reason"),
    [
        ("faulty", 60.0, "not finite"),
        ("picky", 60.0, "^the mesh is too small$"),
        ("broken", 60.0, "^ValueError: first$"),
        ("slow", 0.1, r"^would take longer than 0\.1 s$"),
    ],
)
def test_why_a_model_is_not_run(ask, tmp_path, model, limit_s, reason):
    task, out = (str(tmp_path / name) for name in ("task.npz", "out.npz"))
    assert re.search(reason, ask("faulty", model=model, task=task, out=out, limit_s=limit_s)["not_run"])


OURS = [
    (module.__name__.rpartition(".")[2], model) for module in (ours, ours_inside, ours_cages) for model in module.MODELS
]


@pytest.fixture(scope="module")
def bent_rod():
    """A rod whose upper end is turned, with a bone in each end."""
    mesh = make_mesh("rod", *rod(4.0, 12, 16))
    length = np.ptp(mesh.positions[:, 2])
    z = mesh.positions[:, 2] / length
    held, moved = (np.flatnonzero(m).astype(np.int32) for m in (z < -0.4, z > 0.4))
    motion = turned(X, np.zeros(3), 0.5)
    pose = Pose("bend", mesh, held, moved, motion, View((0, -1, 0), (0, 0, 0), 1.0), steps=2)
    half = 0.5 * length * Z
    return Compared(pose, bones=(Bone(-half, -0.1 * half, still), Bone(0.1 * half, half, motion)))


@pytest.mark.parametrize(("module", "model"), OURS)
def test_our_models_bend_a_rod_and_say_what_it_took(ask, tmp_path, bent_rod, module, model):
    write_posed(tmp_path / "task.npz", posed_task(bent_rod.pose, bent_rod.bones))
    found = ask(module, model=model, task=str(tmp_path / "task.npz"), out=str(tmp_path / "out.npz"), limit_s=60.0)
    assert set(found) == {"version", "acts", "set_up_s", "step_s", "peak_mb"}
    assert len(found["step_s"]) == 2
    with np.load(tmp_path / "out.npz") as data:
        row = shape_row(bent_rod, data["positions"])
    assert row["off"] < (0.05 if "cage" in model or "bones" in model else 0.01)
    assert row["flips"] == 0
    assert 0.8 < row["volume"] < 1.2
