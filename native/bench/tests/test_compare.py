# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of all models: its tasks, its measures, and that every model takes a task."""

import numpy as np
import pytest
from measure.inputs.compared import Compared, linear_part, moved_by, tasks
from measure.inputs.mesh import make_mesh
from measure.inputs.poses import Pose, View, X, Z, turned
from measure.inputs.solids import rod
from measure.pages.compare import cells
from measure.runs.compare import MODELS, edge_strain, pose_with, rotations, row_of
from measure.runs.shape import Surface


@pytest.fixture
def pose():
    mesh = make_mesh("rod", *rod(4.0, 12, 16))
    z = mesh.positions[:, 2] / np.ptp(mesh.positions[:, 2])
    held, moved = (np.flatnonzero(m).astype(np.int32) for m in (z < -0.4, z > 0.4))
    return Pose("bend", mesh, held, moved, turned(X, np.zeros(3), 0.5), View((0, -1, 0), (0, 0, 0), 1.0), steps=2)


def test_the_linear_part_of_a_turn_is_its_rotation_and_of_a_move_nothing(pose):
    turn = linear_part(pose.motion, 1.0)
    assert turn @ turn.T == pytest.approx(np.eye(3))
    assert np.trace(turn) == pytest.approx(1 + 2 * np.cos(0.5))
    assert linear_part(moved_by(Z), 1.0) == pytest.approx(np.eye(3))
    told = rotations(pose, 1.0)
    assert told[0] == pytest.approx(np.eye(3))
    assert told[-1] == pytest.approx(turn)


def test_the_tasks_have_names_of_their_own_and_leave_something_free():
    found = [task.pose for task in tasks()]
    assert len({(pose.mesh.name, pose.name) for pose in found}) == len(found)
    for pose in found:
        assert not set(pose.held) & set(pose.moved)
        assert 0 < len(pose.held) + len(pose.moved) < len(pose.mesh.positions)


def test_strain_of_a_mesh_that_is_twice_as_large_is_one(pose):
    free = np.ones(len(pose.mesh.positions), dtype=bool)
    assert edge_strain(pose.mesh, Surface(pose.mesh), 2 * pose.mesh.positions, free) == pytest.approx(1)


@pytest.mark.parametrize("model", MODELS)
def test_every_model_bends_a_rod_to_its_targets(pose, model):
    row = row_of(Compared(pose), MODELS[model], pose_with(MODELS[model], pose))
    assert row["off"] < 0.01
    assert row["flips"] == 0
    assert 0.8 < row["volume"] < 1.2
    assert len(cells(row)) == 9
