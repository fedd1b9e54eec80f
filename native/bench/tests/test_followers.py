# SPDX-License-Identifier: GPL-3.0-or-later
"""What followers are measured with."""

from __future__ import annotations

import numpy as np
import pytest
from measure.inputs.followers import bent, shell, worn
from measure.metrics.beside import signed_distances
from measure.pages.followers import sections
from measure.runs.followers import dirty_tasks, distances, task_of


@pytest.mark.parametrize("item", list(worn()), ids=lambda item: item.name)
def test_what_is_worn_is_around_the_body_at_rest(item):
    mesh = item.pose.mesh
    away = signed_distances(item.follower, mesh.positions, mesh.triangles)
    assert away.min() > 0.0
    assert np.median(away) == pytest.approx(item.gap, rel=0.15)  # flat faces of a round limb


def test_distances_are_of_vertices_inside_and_of_what_has_moved():
    item = next(worn())
    rest = item.pose.mesh.positions
    kept = distances(item, rest, item.follower)
    assert (kept["inside"], kept["deepest"], kept["offset_rms"]) == (0.0, 0.0, 0.0)
    inside = item.follower * [0.9, 0.9, 1.0]
    found = distances(item, rest, inside)
    assert found["inside"] == 1.0
    assert found["offset_rms"] > found["deepest"] > 1.0  # the gap and the depth together


def test_a_bent_rod_keeps_the_length_of_its_middle():
    mesh, thicker = shell(2000)
    z = np.linspace(mesh.positions[:, 2].min(), mesh.positions[:, 2].max(), 200)
    line = bent(np.stack([0 * z, 0 * z, z], axis=1), 1.0)
    assert np.linalg.norm(np.diff(line, axis=0), axis=1).sum() == pytest.approx(np.ptp(z), rel=1e-4)
    assert np.ptp(thicker[:, 0]) > np.ptp(mesh.positions[:, 0])


def test_each_kind_of_dirty_mesh_is_a_body_and_a_follower():
    tasks = dict(dirty_tasks())
    kinds = {name.partition(": ")[2] for name in tasks}
    assert len(tasks) == 2 * len(kinds) >= 100
    task = tasks["body: needles"]
    assert task.shapes.shape == (1, *task.body.shape)
    assert len(task.follower) == len(tasks["follower: needles"].body)


def test_a_task_has_the_body_at_rest_and_its_shape():
    item = next(worn())
    shape = 2.0 * item.pose.mesh.positions
    task = task_of(item, shape)
    np.testing.assert_array_equal(task.body, item.pose.mesh.positions)
    np.testing.assert_array_equal(task.shapes, shape[None])
    assert task.follower_sizes.sum() == len(task.follower_corners)


def test_pages_tell_what_was_not_carried():
    about = {"follower": "shirt", "pose": "arm raised", "body": "solid"}
    worn_rows = [
        {**about, "model": "ours", "inside": 0.0125, "deepest": 0.5, "offset_rms": 0.25, "picture": "p"},
        {**about, "model": "theirs", "not_run": "refused"},
    ]
    found = sections(
        {
            "machine": {"processor": "P", "cores": 2, "memory_gib": 8, "load": 0.1, "day": "today"},
            "worn": worn_rows,
            "dirty": {"ours": {"n_tasks": 4, "n_bound": 3, "failed": {"body: needles": "why"}}},
            "cost": [
                {"model": "ours", "n_vertices": 100, "bind_s": 0.5, "frame_s": 0.003},
                {"model": "theirs", "n_vertices": 100, "not_run": "refused"},
            ],
        }
    )
    assert "| shirt, arm raised | Solid | ours | 1.2 | 0.50 | 0.25 |" in found["followers-worn"]
    assert "| theirs | refused |" in found["followers-worn"]
    assert "| ours | 3 of 4 |" in found["followers-dirty"]
    assert "| ours | 100 | 0.50 | 3.0 |" in found["followers-cost"]
    assert "| theirs | 100 | - | refused |" in found["followers-cost"]
