# SPDX-License-Identifier: GPL-3.0-or-later
"""The comparison of all models: its tasks, who takes part, and what it keeps of them."""

import json
import sys

import numpy as np
import pytest
from contenders import ours, ours_cages, ours_inside
from measure.base.workers import NotRun
from measure.inputs.bones import rod_bones, twist_between
from measure.inputs.compared import linear_part, moved_by, tasks
from measure.inputs.poses import PULL_RADIUS, X, Z, bar_twist, pull, turned
from measure.pages.compare import PICTURE_MODELS, PICTURE_TASKS, task_table
from measure.runs import compare, contenders, dirty, sizes
from measure.runs.compare import chosen
from measure.runs.contenders import Entry, Library, Reached, entries
from measure.runs.dirty import KINDS, dirty_task, measure_dirty
from measure.runs.posed import posed_task
from measure.runs.quality import file_name
from measure.runs.rows import shape_row
from measure.runs.sizes import measure_sizes


def test_the_linear_part_of_a_turn_is_its_rotation_and_of_a_move_nothing():
    turn = linear_part(turned(X, np.ones(3), 0.5), 1.0)
    assert turn @ turn.T == pytest.approx(np.eye(3))
    assert np.trace(turn) == pytest.approx(1 + 2 * np.cos(0.5))
    assert linear_part(moved_by(Z), 1.0) == pytest.approx(np.eye(3))


@pytest.fixture(scope="module")
def all_tasks():
    return list(tasks())


def test_the_tasks_have_names_of_their_own_and_leave_something_free(all_tasks):
    poses = [task.pose for task in all_tasks]
    assert len({file_name(pose) for pose in poses}) == len(poses)
    for pose in poses:
        assert not set(pose.held) & set(pose.moved)
        assert 0 < len(pose.held) + len(pose.moved) < len(pose.mesh.positions)


def test_bones_keep_their_lengths_and_the_last_ones_go_with_what_is_moved(all_tasks):
    with_bones = [task for task in all_tasks if task.bones]
    assert with_bones
    for task in with_bones:
        ends = np.array([[bone.motion(end[None], 1.0)[0] for end in bone[:2]] for bone in task.bones])
        rest = np.array([bone[:2] for bone in task.bones])
        np.testing.assert_allclose(*(np.linalg.norm(p[:, 1] - p[:, 0], axis=1) for p in (rest, ends)))
        assert any(bone.motion is task.pose.motion for bone in task.bones)


def test_bones_of_a_chain_meet_and_share_a_twist():
    motion = turned(Z, np.zeros(3), 1.0)
    bones = rod_bones(0 * Z, Z, (0.2, 0.8), twist_between(Z, np.zeros(3), 1.0, (0.2, 0.8)), motion)
    np.testing.assert_allclose([bone.tail for bone in bones[:-1]], [bone.head for bone in bones[1:]])
    angles = [np.arctan2(*bone.motion(X[None], 1.0)[0, [1, 0]]) for bone in bones]
    np.testing.assert_allclose(angles, [0, 1 / 6, 1 / 2, 5 / 6, 1], atol=1e-12)


def test_a_pose_becomes_targets_and_turns():
    pose = bar_twist()
    task = posed_task(pose)
    assert task.steps == pose.steps
    np.testing.assert_array_equal(task.targets[-1], pose.task(1.0).targets)
    assert np.trace(task.rotations[-1]) == pytest.approx(1 + 2 * np.cos(0.75 * np.pi))


def test_a_pull_is_the_average_of_a_patch():
    pose = pull("pull", PULL_RADIUS)
    task = posed_task(pose)
    assert task.patch_weights.sum() == pytest.approx(1)
    shift = task.targets[-1, len(task.held) :] - task.positions[task.moved]
    np.testing.assert_allclose(shift, np.tile([0, 0, 0.1], (len(task.moved), 1)), atol=1e-12)


def test_of_a_soup_nothing_is_said_that_needs_neighbours(all_tasks):
    soup = all_tasks[-1]
    rest = soup.pose.mesh.positions
    row = shape_row(soup, 2 * rest)
    assert row["strain"] == pytest.approx(1)
    assert (row["max_deg"], row["dihedral_rms"], row["flips"], row["volume"]) == (None, None, None, None)


def test_a_dirty_mesh_is_held_at_one_end_and_moved_at_the_other():
    for kind in KINDS:
        task = dirty_task(kind)
        assert not set(task.held) & set(task.moved)
        assert len(task.held) > 0
        assert len(task.moved) > 0
        assert np.isfinite(task.targets).all()


def missing_library():
    raise NotRun("not on this machine")


def test_what_the_document_shows_takes_part(all_tasks):
    assert set(PICTURE_TASKS) <= {file_name(task.pose) for task in all_tasks}
    modules = (ours, ours_inside, ours_cages)
    assert {model for model in PICTURE_MODELS if ":" not in model} <= {name for m in modules for name in m.MODELS}


@pytest.fixture
def two_libraries(monkeypatch):
    ours = contenders.LIBRARIES[""]._replace(modules=("ours",))
    monkeypatch.setattr(contenders, "LIBRARIES", {"": ours, "peer": Library(("peer",), missing_library)})


@pytest.mark.usefixtures("two_libraries")
def test_a_library_that_is_not_there_says_why_and_is_not_set_up_unasked():
    found = list(entries([]))
    assert len(found) > 2
    assert found[-1] == Entry("peer: all of peer", not_run="not on this machine")
    assert [entry.name for entry in entries(["solid"])] == ["solid"]
    with pytest.raises(ValueError, match=r"^no model is named liquid\. The names are surface, rotation nodes;"):
        list(entries(["liquid"]))


def test_a_finer_mesh_is_left_out_if_the_task_itself_took_long():
    def after(set_up_s):
        return Reached(np.zeros((1, 3)), {"set_up_s": set_up_s, "step_s": [1.0, 1.0]})

    assert compare.may_be_finer(after(3.0))
    assert not compare.may_be_finer(after(3.1))


def test_a_run_keeps_the_rows_of_models_and_why_others_have_none(tmp_path, monkeypatch):
    out = tmp_path / "compare.json"
    peer = Entry("peer: ARAP", not_run="not on this machine")
    monkeypatch.setattr(compare, "entries", lambda _: [*entries(["Poisson, harmonic"]), peer])
    monkeypatch.setattr(sys, "argv", ["compare", str(out), "--tasks", "plane_pulled_up"])
    compare.main()
    data = json.loads(out.read_text())
    found = data["tasks"]["plane_pulled_up"]
    row = found["rows"]["Poisson, harmonic"]
    assert row["off"] < 1e-6
    assert row["volume"] is None
    assert row["density"] < 0.01
    assert len(row["acts"]) == 3
    assert found["rows"][peer.name] == {"not_run": peer.not_run}
    assert list(data["versions"]) == ["arap_native"]
    assert (tmp_path / "compare" / "plane_pulled_up-Poisson_harmonic.npz").exists()
    assert task_table(found).endswith("- peer: ARAP: not on this machine")


def test_a_task_that_is_not_there_is_refused():
    with pytest.raises(ValueError, match=r"^no task is named bar_cut\. The names are plane_pulled_up, "):
        chosen(["bar_cut"])


def test_sizes_say_what_each_model_took(tmp_path, monkeypatch):
    """A model that fails at one size is not tried at the next."""
    monkeypatch.setattr(sizes, "SIZES", (10_000, 12_000))
    models = [*entries(["Poisson, harmonic"]), Entry("peer: ARAP", not_run="not here")]
    known = [{"model": model, "n_vertices": 1} for model in ("solid", "peer: ARAP")]
    found = measure_sizes(models, tmp_path, known)
    assert [row["model"] for row in found] == ["solid", *2 * ["Poisson, harmonic", "peer: ARAP"]]
    assert found[1]["frame_s"] > 0
    assert found[2]["not_run"] == "not here"
    assert found[4] == {"model": "peer: ARAP", "n_vertices": 12418, "not_run": "at 12418 vertices: not here"}


@pytest.mark.parametrize(
    ("row", "reason"),
    [
        ({"set_up_s": 1.0, "frame_s": 18.9}, None),
        ({"set_up_s": 1.0, "frame_s": 21.0}, "would take longer than 90 s: at 12000 vertices it takes 22 s"),
        ({"not_run": "no weights"}, "at 12000 vertices: no weights"),
    ],
)
def test_a_size_that_cannot_succeed_is_not_tried(row, reason):
    assert sizes.why_hopeless_if_larger({"n_vertices": 12000, **row}) == reason


def test_dirty_meshes_that_a_model_refuses_are_counted_with_the_reason(tmp_path, monkeypatch):
    monkeypatch.setattr(dirty, "KINDS", ("open_seams", "nothing_but_loose"))
    models = [*entries(["solid"]), Entry("peer: ARAP", not_run="not here")]
    found = measure_dirty(models, tmp_path, {})
    assert (found["solid"]["n_bound"], found["solid"]["n_meshes"]) == (1, 2)
    assert list(found["solid"]["failed"]) == ["nothing_but_loose"]
    assert found["peer: ARAP"] == {"not_run": "not here"}
