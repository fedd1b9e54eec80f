# SPDX-License-Identifier: GPL-3.0-or-later
"""Between two motions, and their mirror images."""

import numpy as np
import pytest
import sample_meshes
from arap_deform.core.transforms import rotation
from arap_deform.poses.blend import blended, mirrored, partners

ORIGIN = np.zeros((1, 3))
UNSTRETCHED = np.eye(3)


def turn(axis, angle_rad):
    """(3, 3) about any axis."""
    return rotation(np.asarray(axis) * (angle_rad / np.linalg.norm(axis)))


def motion(linear=UNSTRETCHED, shift=(0.0, 0.0, 0.0), about=(0.0, 0.0, 0.0)):
    """(4, 4) x -> linear (x - about) + about + shift."""
    return sample_meshes.motion(linear, np.asarray(about) - linear @ np.asarray(about) + shift)


def between(first, second, factor, pivot=ORIGIN, stretch=UNSTRETCHED):
    return blended(["Hand"], first[None], second[None], factor, pivot, stretch)[0]


def random_rigid(rng):
    return motion(turn(rng.normal(size=3), rng.uniform(0.1, 3.0)), rng.normal(size=3))


def test_the_ends_are_the_two_poses():
    rng = np.random.default_rng(1)
    for _ in range(20):
        first = random_rigid(rng) @ motion(np.diag(rng.uniform(0.3, 3.0, 3)))
        second = random_rigid(rng) @ motion(np.diag(rng.uniform(0.3, 3.0, 3)))
        pivot = rng.normal(size=(1, 3))
        np.testing.assert_allclose(between(first, second, 0.0, pivot), first, atol=1e-12)
        np.testing.assert_allclose(between(first, second, 1.0, pivot), second, atol=1e-12)


def test_a_straight_move_stays_straight():
    second = motion(shift=(4.0, -2.0, 1.0))
    np.testing.assert_allclose(between(np.eye(4), second, 0.25), motion(shift=(1.0, -0.5, 0.25)), atol=1e-14)


def test_half_of_a_turn_is_half_the_angle_about_the_same_axis():
    for angle in (1e-9, 1e-4, 0.7, 2.9, np.pi - 1e-9):
        second = motion(turn((1.0, 2.0, -1.0), angle), about=(3.0, 1.0, 0.0))
        expected = motion(turn((1.0, 2.0, -1.0), angle / 2), about=(3.0, 1.0, 0.0))
        np.testing.assert_allclose(between(np.eye(4), second, 0.5), expected, atol=1e-8)


def test_rotations_turn_the_short_way():
    """From 170 to -170 degrees it is 20 degrees, through the back and not through the front."""
    first, second = (motion(turn((0.0, 0.0, 1.0), np.radians(degrees))) for degrees in (170.0, -170.0))
    expected = motion(turn((0.0, 0.0, 1.0), np.pi))
    np.testing.assert_allclose(between(first, second, 0.5), expected, atol=1e-12)


def test_a_swinging_arm_keeps_its_length():
    """A hand that has swung about the shoulder is on the circle all the way, wherever its own pivot is."""
    second = motion(turn((0.0, 0.0, 1.0), 2.0))
    for factor in np.linspace(0.0, 1.0, 9):
        hand = between(np.eye(4), second, factor, np.array([[2.0, 0.0, 0.0]])) @ (2.0, 0.0, 0.0, 1.0)
        assert np.linalg.norm(hand[:3]) == pytest.approx(2.0, abs=1e-12)


def test_handles_that_go_the_same_way_stay_together():
    """Two poses that differ by one rigid motion are joined by rigid motions of the whole."""
    rng = np.random.default_rng(2)
    first = np.array([random_rigid(rng) for _ in range(5)])
    whole = random_rigid(rng)
    pivots = rng.normal(size=(5, 3))
    half = blended(list("abcde"), first, whole @ first, 0.5, pivots, UNSTRETCHED)
    moves = half @ np.linalg.inv(first)
    np.testing.assert_allclose(moves, np.broadcast_to(moves[0], moves.shape), atol=1e-12)
    np.testing.assert_allclose(moves[0] @ moves[0], whole, atol=1e-12)


def test_the_way_back_is_the_same_way():
    rng = np.random.default_rng(3)
    first, second = (random_rigid(rng) @ motion(np.diag(rng.uniform(0.5, 2.0, 3))) for _ in range(2))
    np.testing.assert_allclose(between(first, second, 0.3), between(second, first, 0.7), atol=1e-12)


def test_scales_blend_by_their_ratios_about_the_handle():
    pivot = np.array([[1.0, 2.0, 3.0]])
    second = motion(np.diag([4.0, 1.0, 0.25]), about=pivot[0])
    expected = motion(np.diag([2.0, 1.0, 0.5]), about=pivot[0])
    np.testing.assert_allclose(between(np.eye(4), second, 0.5, pivot), expected, atol=1e-12)


def test_a_turned_and_scaled_handle_gets_no_shear_on_its_own_axes():
    """What object and bone transforms can show: turned axes, scaled each."""
    axes = turn((1.0, 1.0, 0.0), 0.8)
    first = motion(axes @ np.diag([1.0, 2.0, 3.0]) @ axes.T)
    second = motion(turn((0.0, 1.0, 2.0), 1.5) @ axes @ np.diag([2.0, 1.0, 0.5]) @ axes.T)
    place = between(first, second, 0.4)[:3, :3] @ axes
    gram = place.T @ place
    np.testing.assert_allclose(gram, np.diag(gram.diagonal()), atol=1e-12)


def test_volume_never_dips():
    rng = np.random.default_rng(4)
    for _ in range(20):
        first, second = (random_rigid(rng) @ motion(np.diag(rng.uniform(0.2, 4.0, 3))) for _ in range(2))
        volumes = [np.linalg.det(m[:3, :3]) for m in (first, between(first, second, 0.5), second)]
        assert volumes[1] == pytest.approx(np.sqrt(volumes[0] * volumes[2]), rel=1e-9)


def test_rigid_as_seen_on_a_stretched_object():
    """A turn of the world is a shear in the space of an unevenly scaled object, and half of it another one."""
    stretch = np.array([[2.0, 0.3, 0.0], [0.3, 1.0, 0.0], [0.0, 0.0, 0.5]])
    to_seen, from_seen = motion(stretch), motion(np.linalg.inv(stretch))
    second = from_seen @ motion(turn((0.0, 1.0, 0.0), 1.2), (1.0, 0.0, 2.0)) @ to_seen
    half = to_seen @ between(np.eye(4), second, 0.5, stretch=stretch) @ from_seen
    np.testing.assert_allclose(half[:3, :3], turn((0.0, 1.0, 0.0), 0.6), atol=1e-12)


def test_beyond_the_ends_it_goes_on():
    second = motion(turn((0.0, 0.0, 1.0), 0.5), about=(1.0, 0.0, 0.0))
    expected = motion(turn((0.0, 0.0, 1.0), 0.75), about=(1.0, 0.0, 0.0))
    np.testing.assert_allclose(between(np.eye(4), second, 1.5), expected, atol=1e-12)


@pytest.mark.parametrize("scale", [(-1.0, 1.0, 1.0), (1.0, 0.0, 1.0), (0.0, 0.0, 0.0)])
def test_flat_and_inside_out_handles_are_refused(scale):
    message = (
        "^Handle 'Hand' is flat or turned inside out in one of the poses: scale it back and store that pose again$"
    )
    with pytest.raises(ValueError, match=message):
        between(np.eye(4), motion(np.diag(scale)), 0.5)


def test_the_mirror_image_of_a_motion_moves_the_mirror_image_of_a_point():
    rng = np.random.default_rng(5)
    for axis in range(3):
        there = random_rigid(rng)
        image = np.ones(4)
        image[axis] = -1.0
        point = np.array([*rng.normal(size=3), 1.0])
        np.testing.assert_allclose(mirrored(there, axis) @ (image * point), image * (there @ point), atol=1e-14)
        assert np.linalg.det(mirrored(there, axis)[:3, :3]) == pytest.approx(1.0)
        np.testing.assert_array_equal(mirrored(mirrored(there, axis), axis), there)


def test_partners_by_name_then_by_place():
    names = ["Hand.L", "Hand.R", "Head", "Left", "Right"]
    flipped = ["Hand.R", "Hand.L", "Head", "Left", "Right"]
    places = np.array([[1.0, 0, 0], [-7.0, 0, 0], [0.005, 0, 2], [2.0, 0, 0], [-2.001, 0, 0]])
    assert partners(names, flipped, places, 0, 0.02, set(range(5))) == {0: 1, 1: 0, 2: 2, 3: 4, 4: 3}
    assert partners(names, flipped, places, 0, 0.02, {3}) == {3: 4}


def test_a_side_in_the_name_without_its_partner_goes_by_place():
    places = np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    assert partners(["Hand.L", "Other"], ["Hand.R", "Other"], places, 0, 0.1, {0, 1}) == {0: 1, 1: 0}


def test_a_missing_partner_is_refused():
    places = np.array([[1.0, 0.0, 0.0]])
    for name, flipped, named in (("Hand.L", "Hand.R", "named 'Hand.R' or "), ("Hand", "Hand", "")):
        message = (
            f"^Handle '{name}' has no partner on the other side of X = 0: add a handle {named}at its mirrored place, "
            "or choose another axis$"
        )
        with pytest.raises(ValueError, match=message):
            partners([name], [flipped], places, 0, 0.1, {0})
    assert partners(["Hand"], ["Hand"], places, 1, 0.1, {0}) == {0: 0}


def test_partners_that_disagree_are_refused():
    places = np.array([[1.0, 0, 0], [-1.0, 0, 0], [1.01, 0, 0]])
    message = (
        "^The mirror image of handle 'C' is 'B', but the mirror image of 'B' is 'A': "
        "give them names with sides, for example Hand.L and Hand.R$"
    )
    with pytest.raises(ValueError, match=message):
        partners(["A", "B", "C"], ["A", "B", "C"], places, 0, 0.1, {0, 1, 2})
