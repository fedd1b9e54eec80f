# SPDX-License-Identifier: GPL-3.0-or-later
"""What contenders of other libraries share; their libraries are not here."""

import os
import sys

import numpy as np
import pytest
from contenders import same_models
from contenders.bones import bones_of
from contenders.carriers import Carrier, groups
from contenders.printed import Printed
from contenders.steps import motion_of_moved, settled
from measure.base.contender import STEP_ITERATIONS, PosedTask
from measure.base.workers import NotRun
from measure.inputs.solids import cubes, sheet
from measure.inputs.tasks import rotation
from measure.pages.same_models import excess
from measure.pages.same_models import same_models as same_models_page
from measure.runs import same_models as run
from measure.runs.contenders import Entry

TURN, SHIFT = rotation(np.array([1.0, 2.0, 3.0]), 0.7), np.array([0.1, 0.2, 0.3])


def task_of(surface, held, moved, steps=2):
    """What is moved turned by TURN and moved by SHIFT, at once."""
    positions, triangles = surface
    held, moved = (np.flatnonzero(mask).astype(np.int32) for mask in (held, moved))
    targets = np.concatenate([positions[held], positions[moved] @ TURN.T + SHIFT])
    sizes = np.full(len(triangles), 3, dtype=np.int32)
    turns = np.tile(TURN, (steps, 1, 1))
    return PosedTask(positions, triangles.ravel(), sizes, held, moved, np.tile(targets, (steps, 1, 1)), turns)


@pytest.fixture
def task():
    """A bar along x of length 1, two sides of its start held, its end moved."""
    positions, triangles = cubes(np.ones((20, 2, 2), dtype=bool), 0.05)
    x, y, _ = positions.T
    return task_of((positions, triangles), (x < 0.21) & (y != 0.05), x > 0.89)


def test_calls_end_where_one_moves_nothing_more():
    calls = []

    def halved(places):
        calls.append(places)
        return 0.1 * places

    assert np.abs(settled(halved, np.array([[1.0, 0.0, 0.0]]))).max() < 1e-5
    assert len(calls) == 6
    calls.clear()
    settled(lambda places: calls.append(places) or places + 1.0, np.ones((2, 3)))
    assert 10 * len(calls) == STEP_ITERATIONS


def test_the_motion_of_what_is_moved_takes_it_to_its_targets(task):
    turn, shift = motion_of_moved(task, 1)
    np.testing.assert_allclose(turn, TURN)
    np.testing.assert_allclose(shift, SHIFT)


def test_each_piece_has_a_bone_along_it_and_takes_it_along(task):
    bones = bones_of(task)
    assert bones.rest.shape == (3, 2, 3)
    along = bones.rest[:, 1] - bones.rest[:, 0]
    np.testing.assert_allclose(np.abs(along[:2]), [[0.16, 0.0, 0.0]] * 2, atol=1e-9)
    points = np.array([[1.0, 0.0, 0.0], [0.9, 0.1, 0.1]])
    np.testing.assert_allclose(bones.moved(1, 0, points), points)
    np.testing.assert_allclose(bones.moved(1, 2, points), points @ TURN.T + SHIFT)


def test_faces_cut_apart_are_one_piece(task):
    corners = task.corner_vertices
    cut = [np.flatnonzero(np.isin(corners, part)).astype(np.int32) for part in (task.held, task.moved)]
    targets = np.tile(task.positions[corners[np.concatenate(cut)]], (task.steps, 1, 1))
    soup = task._replace(
        positions=task.positions[corners],
        corner_vertices=np.arange(len(corners), dtype=np.int32),
        held=cut[0],
        moved=cut[1],
        targets=targets,
    )
    assert len(bones_of(soup).rest) == 2


def test_what_is_held_all_around_has_no_place_for_a_bone():
    positions, triangles = sheet((1.0, 1.0), (10, 10))
    away = np.abs(positions - [0.5, 0.0, 0.0]).max(axis=1)
    with pytest.raises(NotRun, match="no place for a bone"):
        bones_of(task_of((positions, triangles), away > 0.45, away < 0.15))


def test_a_coarse_mesh_is_held_and_moved_next_to_what_is(task):
    held, moved = groups(task, np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    assert (held.tolist(), moved.tolist()) == ([0], [2])
    box, faces = cubes(np.ones((4, 1, 1), dtype=bool), 0.3)
    carrier = Carrier(task, box - 0.1, faces.ravel(), np.full(len(faces), 3, dtype=np.int32))
    far = np.flatnonzero(box[:, 0] > 1.1)
    np.testing.assert_allclose(carrier.pose(1)[far], (box - 0.1)[far] @ TURN.T + SHIFT, atol=1e-6)


def test_coarse_vertices_that_are_as_near_are_chosen_together(task):
    places = np.array([[0.0, 0.0, 0.1], [1.0, 0.0, 0.0], [0.0, 0.0, -0.1 * (1 + 1e-15)], [0.0, 0.0, 0.2]])
    vertices = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.1]])
    own = np.arange(2, dtype=np.int32)
    one = task._replace(positions=vertices, held=own[:1], moved=own[1:])
    held, moved = groups(one, places)
    assert (held.tolist(), moved.tolist()) == ([0, 2], [1])


def test_what_is_printed_below_python_is_read():
    with Printed() as printed:
        os.write(1, b"Exception: first\nall well\nException:  too thin \n")
        os.write(2, b"no mark\n")
    assert printed.after("Exception:") == "too thin"
    assert printed.after("Warning:") == ""


class Shifted:
    """Everything at its targets, or a tenth beside; its energy is the mean of x."""

    version = "1"

    def __init__(self, task, shift):
        self._task, self._shift = task, shift

    def pose(self, step):
        self._now = np.full_like(self._task.positions, step) + self._shift

    def positions(self):
        return self._now

    def energy(self, places):
        return places[:, 0].mean()


def test_two_models_are_compared_where_they_end(task):
    found = same_models.compared([lambda t: Shifted(t, 0.0), lambda t: Shifted(t, [0.1, 0.0, 0.0])], task)
    assert found["distance"] == pytest.approx(0.1)
    assert found["energies"] == pytest.approx([1.0, 1.1])
    assert np.shape(found["set_up_s"]) == (same_models.SET_UPS, 2)
    assert np.shape(found["step_s"]) == (task.steps, 2)


def test_a_pair_has_a_row_for_each_task_and_the_rest_are_alone(tmp_path, monkeypatch):
    monkeypatch.setattr(run, "PAIRS", (run.Pair("ours", "Poisson, harmonic", "Poisson, harmonic", (run.ROD,)),))
    command = (sys.executable, "-m", "contenders.worker", "ours")
    missing = Entry("X: other", not_run="it is not there")
    found = run.measure_same_models([Entry("Poisson, harmonic", command), missing], tmp_path)
    assert found["alone"] == ["X: other"]
    (row,) = found["rows"]
    assert (row["ours"], row["task"], row["distance"], row["energies"]) == ("Poisson, harmonic", run.ROD, 0.0, None)
    assert len(row["step_s"]) == len(row["set_up_s"]) == 2
    assert row["step_ratio"] > 0


def test_the_page_has_pairs_then_what_did_not_run_then_what_is_alone():
    pair = {"ours": "surface", "theirs": "X: ARAP", "task": "rod_bend"}
    row = pair | {"version": "2", "distance": 1.4e-5, "energies": [2.0, 2.002], "step_ratio": 25.04}
    row |= {"set_up_s": [0.1, 0.2], "step_s": [0.004, 0.1]}
    page = same_models_page({"rows": [row, pair | {"not_run": "no X here"}], "alone": ["X: other"]})
    table, missing, alone = page.split("\n\n")
    cells = "| surface | X: ARAP (2) | rod bend | 1e-05 | +1e-03 | 0.10 | 0.20 | 4.0 | 100 | 25 |"
    assert table.splitlines()[2] == cells
    assert missing == "- X: ARAP, rod_bend: no X here"
    assert alone == "No model of ours is the same as X: other."
    assert excess(None) == "-"
