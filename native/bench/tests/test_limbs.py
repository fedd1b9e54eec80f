# SPDX-License-Identifier: GPL-3.0-or-later
"""Limbs and what is measured of them: facts on rods, whose sections and volumes are known."""

import numpy as np
import pytest
from measure.inputs.limbs import (
    ROD_HELD,
    ROD_LENGTH,
    creature_legs,
    fingers,
    legs,
    rod_mesh,
    rods,
    second_bone_targets,
)
from measure.inputs.solids import rod
from measure.metrics.sections import section_area, thinnest_section, volume
from measure.runs.cost import medians, ratio
from measure.runs.limb_models import skinned
from measure.runs.steady import turned_pose
from surfaces import is_closed

AREA = 0.5 * 48 * 0.25 * np.sin(2 * np.pi / 48)  # of a polygon of 48 corners and diameter 1


@pytest.fixture
def limb():
    return next(rods())


def test_a_rod_is_closed_and_has_the_volume_of_its_prism():
    positions, triangles = rod(6.0, 48, 92)
    assert is_closed(triangles)
    assert volume(positions, triangles) == pytest.approx(6 * AREA)


def test_a_section_has_the_area_of_the_polygon_however_it_is_turned():
    positions, triangles = rod(6.0, 48, 92)
    heights = positions[:, 2] - 0.123
    assert section_area(heights, positions, triangles) == pytest.approx(AREA)
    turned = positions[:, [2, 0, 1]] + [3.0, -1.0, 2.0]
    assert section_area(heights, turned, triangles) == pytest.approx(AREA)


def test_an_oblique_section_of_the_rest_is_an_ellipse():
    positions, triangles = rod(6.0, 48, 92)
    heights = positions @ [0.0, 0.6, 0.8] - 1e-4
    assert section_area(heights, positions, triangles) == pytest.approx(AREA / 0.8, rel=1e-3)


def test_the_thinnest_section_is_a_share_of_that_at_rest(limb):
    rest = limb.pose.mesh.positions
    assert thinnest_section(limb, rest) == pytest.approx(1)
    narrow = 1 - 0.5 * np.exp(-((rest[:, 2] / 0.05) ** 2))
    assert thinnest_section(limb, rest * np.stack([narrow, narrow, np.ones(len(rest))], axis=1)) == pytest.approx(
        0.25, abs=1e-3
    )


def test_linear_skinning_closes_a_rod_that_is_twisted_by_180():
    limb = next(limb for limb in rods() if limb.pose.name == "two bones, twist by 180")
    assert thinnest_section(limb, skinned(limb, limb.weights)) < 1e-6


def test_the_second_bone_has_four_targets_that_move():
    bones = np.array([[[0, 0, -2.0], [0, 0, 0]], [[0, 0, 0], [0, 0, 2.0]]])
    targets = second_bone_targets(bones, lambda points, share: np.add(points, [0.0, share, 0.0]), 0.5)
    np.testing.assert_allclose(targets[:4], [[0, 0, -2], [2, 0, -2], [0, 2, -2], [0, 0, 0]])
    np.testing.assert_allclose(targets[4:], [[0, 0.5, 0], [2, 0.5, 0], [0, 2.5, 0], [0, 0.5, 2]])


def test_motions_start_at_rest():
    for limb in [*rods(), *creature_legs()]:
        rest = limb.pose.mesh.positions
        np.testing.assert_allclose(limb.pose.motion(rest, 0.0), rest, atol=1e-12)


def test_handles_do_not_overlap_and_what_is_measured_is_free():
    for limb in rods():
        pose = limb.pose
        assert not np.intersect1d(pose.held, pose.moved).size
        if limb.bones is None:
            assert not limb.is_measured[np.concatenate([pose.held, pose.moved])].any()


def test_a_bend_keeps_the_length_of_the_free_axis():
    _, bend, *_ = rods()
    _, width = rod_mesh()
    free = (ROD_LENGTH - 2 * ROD_HELD) * width
    top = 0.5 * free * np.array([[0.0, 0.0, 1.0]])
    radius = free / np.radians(120)
    chord = np.linalg.norm(bend.pose.motion(top, 1.0) + top)
    assert chord == pytest.approx(2 * radius * np.sin(np.radians(60)))


def test_the_fingers_are_one_closed_part():
    pose, is_other, width = fingers()
    assert is_closed(pose.mesh.triangles)
    x, _, z = pose.mesh.positions.T
    assert np.ptp(x[is_other]) == pytest.approx(width)
    assert not is_other[pose.moved].any()
    assert z[pose.held].max() < z[is_other].min()


def test_without_its_mesh_no_leg_is_measured():
    assert not list(legs(""))


def test_a_turned_pose_is_the_same_pose_elsewhere(limb):
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    shift = np.array([1.0, 2.0, 3.0])
    pose, moved = limb.pose, turned_pose(limb.pose, turn, shift)
    np.testing.assert_allclose((moved.task(0.5).targets - shift) @ turn, pose.task(0.5).targets, atol=1e-12)


def test_a_cost_is_the_median_of_its_rounds_and_its_ratio_that_of_each_round():
    ours, surface = ([{"frame_s": s} for s in times] for times in ([1.0, 4.0, 3.0], [2.0, 4.0, 12.0]))
    assert medians(ours) == {"frame_s": 3.0}
    assert ratio(ours, surface) == 0.5  # of .5, 1, .25
    failed = {"not_run": "no memory"}
    assert medians([*ours, failed]) == failed
    assert ratio(ours, [*surface[:2], failed]) is None
