# SPDX-License-Identifier: GPL-3.0-or-later
"""From the mouse to motions: projections undo themselves, drags are rigid and do what their mode says."""

import numpy as np
import pytest
from arap_deform.core.transforms import rotation
from arap_deform.pull.drag import TURN_PER_PIXEL, Drag, Lever, Mode, press_place
from arap_deform.pull.view import View
from sample_meshes import rotation_z

SIZE = (800, 600)
NEAR, FAR = 0.1, 100.0


def looking_down(*, is_perspective, turn=None):
    """From z = 10 down, x to the right and y up; ``turn``: (3, 3), turns the world first."""
    world = np.eye(4)
    world[:3, :3] = np.eye(3) if turn is None else turn
    world[2, 3] = -10.0
    ratio = SIZE[0] / SIZE[1]
    if is_perspective:
        lens = np.diag([1.5, 1.5 * ratio, 0.0, 0.0])
        lens[2, 2], lens[2, 3] = -(FAR + NEAR) / (FAR - NEAR), -2.0 * FAR * NEAR / (FAR - NEAR)
        lens[3, 2] = -1.0
    else:
        lens = np.diag([0.25, 0.25 * ratio, -2.0 / (FAR - NEAR), 1.0])
        lens[2, 3] = -(FAR + NEAR) / (FAR - NEAR)
    return View(lens @ world, SIZE)


TILT = rotation(np.array([0.6, 0.0, 0.0])) @ rotation_z(0.4)
VIEWS = [looking_down(is_perspective=p, turn=turn) for p in (True, False) for turn in (None, TILT)]
PLACE = np.array([0.3, -0.2, 0.5])
NORMAL = np.array([0.6, 0.0, 0.8])


@pytest.mark.parametrize("view", VIEWS)
def test_a_ray_passes_through_what_is_seen_at_its_pixel(view):
    pixel = view.pixels(PLACE[None])[0]
    origin, direction = view.ray(pixel)
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    away = PLACE - origin
    np.testing.assert_allclose(away - direction * (away @ direction), 0.0, atol=1e-9)
    assert away @ direction > 0.0


@pytest.mark.parametrize("view", VIEWS)
def test_at_depth_of_undoes_pixels_and_keeps_the_depth(view):
    np.testing.assert_allclose(view.at_depth_of(PLACE, view.pixels(PLACE[None])[0]), PLACE, atol=1e-9)
    other = view.at_depth_of(PLACE, (20.0, 500.0))
    np.testing.assert_allclose(view.pixels(other[None])[0], (20.0, 500.0), atol=1e-7)
    assert (other - PLACE) @ view.towards_viewer(PLACE) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("view", VIEWS)
def test_the_viewer_is_where_rays_come_from(view):
    _, direction = view.ray((400.0, 300.0))
    np.testing.assert_allclose(view.towards_viewer(PLACE), -direction, atol=1e-9)


def test_pixels_are_larger_farther_away_in_perspective_alone():
    perspective, flat = looking_down(is_perspective=True), looking_down(is_perspective=False)
    near, far = np.array([0.0, 0.0, 5.0]), np.array([0.0, 0.0, 0.0])
    assert perspective.pixel_size(far) == pytest.approx(2.0 * perspective.pixel_size(near))
    assert flat.pixel_size(far) == pytest.approx(flat.pixel_size(near))
    assert flat.pixel_size(far) == pytest.approx(8.0 / 800.0)


def test_nothing_behind_the_viewer_has_a_pixel():
    view = looking_down(is_perspective=True)
    assert np.isnan(view.pixels(np.array([[0.0, 0.0, 11.0]]))).all()


def begun(view, mode=Mode.MOVE):
    start = view.pixels(PLACE[None])[0]
    drag = Drag(view, start, PLACE, NORMAL)
    drag.set_mode(mode)
    return drag, start


def assert_rigid(motion):
    np.testing.assert_allclose(motion[:3, :3] @ motion[:3, :3].T, np.eye(3), atol=1e-12)
    assert np.linalg.det(motion[:3, :3]) == pytest.approx(1.0)
    np.testing.assert_array_equal(motion[3], (0.0, 0.0, 0.0, 1.0))


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("mode", list(Mode))
def test_every_motion_is_rigid_and_none_at_the_start(view, mode):
    drag, start = begun(view, mode)
    np.testing.assert_allclose(drag.motion, np.eye(4), atol=1e-9)
    drag.to(np.add(start, (35.0, -20.0)))
    assert_rigid(drag.motion)
    assert np.abs(drag.motion - np.eye(4)).max() > 1e-3


@pytest.mark.parametrize("view", VIEWS)
def test_a_move_stays_under_the_mouse_and_in_the_plane_that_faces_the_viewer(view):
    drag, start = begun(view)
    drag.to(np.add(start, (60.0, 25.0)))
    np.testing.assert_allclose(view.pixels(drag.place[None])[0], np.add(start, (60.0, 25.0)), atol=1e-6)
    assert (drag.place - PLACE) @ view.towards_viewer(PLACE) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("axis", [0, 1])
def test_a_move_along_an_axis_goes_as_far_as_the_mouse(view, axis):
    """The mouse goes where the place would be seen after a move along the axis: then that is the move."""
    drag, start = begun(view)
    wanted = PLACE + 0.7 * np.eye(3)[axis]
    drag.toggle_axis(axis)
    drag.to(view.pixels(wanted[None])[0])
    np.testing.assert_allclose(drag.place, wanted, atol=1e-6)
    drag.toggle_axis(axis)
    assert drag.axis is None
    assert start is not None


def test_along_the_line_of_sight_the_mouse_goes_up_instead():
    drag, start = begun(looking_down(is_perspective=False))
    drag.toggle_axis(2)
    drag.to(np.add(start, (40.0, 50.0)))
    np.testing.assert_allclose(drag.place - PLACE, (0.0, 0.0, 50.0 * 8.0 / 800.0), atol=1e-9)


def test_along_the_normal_up_is_outwards():
    drag, start = begun(looking_down(is_perspective=False), Mode.NORMAL)
    drag.to(np.add(start, (99.0, 50.0)))
    np.testing.assert_allclose(drag.place - PLACE, 0.5 * NORMAL, atol=1e-9)


def test_a_turn_is_about_the_place_and_the_line_of_sight_or_an_axis():
    drag, start = begun(looking_down(is_perspective=False), Mode.TURN)
    drag.to(np.subtract(start, (90.0, 0.0)))
    np.testing.assert_allclose(drag.place, PLACE, atol=1e-12)
    np.testing.assert_allclose(drag.motion[:3, :3], rotation_z(90.0 * TURN_PER_PIXEL), atol=1e-9)
    drag.toggle_axis(0)
    np.testing.assert_allclose(drag.motion[:3, 0], (1.0, 0.0, 0.0), atol=1e-12)


def test_another_mode_goes_on_from_where_the_drag_is():
    drag, start = begun(looking_down(is_perspective=True))
    drag.to(np.add(start, (60.0, 0.0)))
    before = drag.motion
    drag.set_mode(Mode.TURN)
    np.testing.assert_allclose(drag.motion, before, atol=1e-12)
    place = drag.place
    drag.to(start + np.subtract((60.0, 0.0), (90.0, 0.0)))
    np.testing.assert_allclose(drag.place, place, atol=1e-9)
    assert_rigid(drag.motion)


PIVOT = PLACE - np.array([1.0, 0.0, 0.0])


def hung(length, axis=None):
    """A drag of the end of a limb along x, seen from above; and how to move it by a shift in x and y."""
    view = looking_down(is_perspective=False)
    drag = Drag(view, view.pixels(PLACE[None])[0], PLACE, NORMAL, Lever(PIVOT, length))
    drag.axis = axis

    def move(x, y):
        drag.to(view.pixels((PLACE + np.array([x, y, 0.0]))[None])[0])

    return drag, move


def test_a_limb_stops_where_it_is_straight_unless_it_stretches():
    drag, move = hung(1.5)
    move(0.3, 0.0)
    assert not drag.is_beyond
    move(2.0, 4.0)
    assert drag.is_beyond
    np.testing.assert_allclose(drag.place - PIVOT, 1.5 * np.array([0.6, 0.8, 0.0]), atol=1e-9)
    np.testing.assert_allclose(drag.wanted, PLACE + np.array([2.0, 4.0, 0.0]), atol=1e-9)
    drag.is_stretching = True
    assert not drag.is_beyond
    np.testing.assert_allclose(drag.place, drag.wanted, atol=1e-9)


def test_a_straight_limb_does_not_get_shorter():
    drag, move = hung(0.8)
    move(-1.0, 2.0)
    assert np.linalg.norm(drag.place - PIVOT) == pytest.approx(1.0)


def test_a_piece_turns_with_its_limb_unless_told_not_to():
    drag, move = hung(1.0)
    move(-1.0, 1.0)
    np.testing.assert_allclose(drag.motion[:3, :3], rotation_z(np.pi / 2), atol=1e-9)
    np.testing.assert_allclose(drag.place, PIVOT + np.array([0.0, 1.0, 0.0]), atol=1e-9)
    drag.is_turning_along = False
    np.testing.assert_array_equal(drag.motion[:3, :3], np.eye(3))


@pytest.mark.parametrize("axis", [None, 2])
def test_shift_turns_a_limb_about_its_joint_the_way_of_the_mouse(axis):
    drag, move = hung(1.0, axis)
    drag.set_mode(Mode.TURN)
    move(0.0, 0.2)
    np.testing.assert_allclose(drag.motion[:3, :3] @ PIVOT + drag.motion[:3, 3], PIVOT, atol=1e-9)
    assert 0.15 < (drag.place - PLACE)[1] < 0.25
    move(0.0, -0.2)
    assert -0.25 < (drag.place - PLACE)[1] < -0.15


def test_about_the_line_of_sight_a_limb_stays_under_the_mouse():
    drag, move = hung(1.0)
    drag.set_mode(Mode.TURN)
    move(-1.8, 0.6)
    np.testing.assert_allclose(drag.place - PIVOT, np.array([-0.8, 0.6, 0.0]), atol=1e-9)


@pytest.mark.parametrize(
    ("told", "before", "first_move", "is_behind", "place"),
    [
        ((100, 100), (100, 100), (100, 104), False, (100, 100)),  # nothing is late
        ((100, 100), (100, 100), (100, 150), False, (100, 100)),  # a flick
        ((100, 170), (100, 100), (100, 111), True, (100, 100)),  # the press was read late
        ((100, 135), (400, 300), (100, 111), True, (100, 111)),  # and it moved there in one go
        ((100, 100), (400, 300), (100, 111), True, (100, 100)),
    ],
)
def test_a_press_that_is_read_late_was_where_the_moves_begin(told, before, first_move, is_behind, place):
    assert press_place(told, before, first_move, is_behind=is_behind) == place
