# SPDX-License-Identifier: GPL-3.0-or-later
"""An attached object bound to what carries it, in the spaces of both. What a wrap computes: tests/native."""

from dataclasses import replace

import arap_native
import numpy as np
import pytest
from arap_deform.core.attach.wrap import Wrap
from arap_deform.core.attach.wrap_input import WrapInput
from arap_deform.core.background import run
from arap_deform.core.mirror import Mirror
from arap_deform.core.session_data import SessionMesh
from arap_deform.core.transforms import transformed
from sample_meshes import ball, motion, rotation_z, tube

PLACE = motion(rotation_z(0.4) @ np.diag([0.1, 0.2, 0.3]), (3.0, 0.5, 1.0))
STRETCH = np.diag([1.0, 2.0, 0.5])


def carrying(**changes) -> WrapInput:
    """Points about a tube, in the space of an object that stands elsewhere, turned and scaled."""
    about = tube().positions[20:40] * (1.2, 1.2, 1.0)
    points = transformed(np.linalg.inv(changes.get("place", PLACE)), about).astype(np.float32)
    given = {"name": "Sleeve", "mesh": SessionMesh(*tube()), "stretch": np.eye(3), "points": points, "place": PLACE}
    return WrapInput(**{**given, **changes})


def bound(inputs: WrapInput) -> Wrap:
    return run(Wrap.bind(arap_native, inputs))


def in_body(inputs: WrapInput, positions: np.ndarray) -> np.ndarray:
    return transformed(inputs.place, positions.astype(np.float64))


def test_at_rest_it_is_exactly_at_rest():
    inputs = carrying()
    rest = tube().positions.astype(np.float32)
    assert np.array_equal(bound(inputs).carried(rest), inputs.points)


@pytest.mark.parametrize("stretch", [np.eye(3), STRETCH], ids=["plain", "stretched"])
@pytest.mark.parametrize("pieces", [None, np.zeros(20, np.int32)], ids=["bend", "rigid"])
def test_what_turns_as_seen_takes_it_along(stretch, pieces):
    inputs = carrying(stretch=stretch, pieces=pieces)
    turn = motion(np.linalg.inv(stretch) @ rotation_z(1.0) @ stretch, (0.0, 1.0, -2.0))
    moved = transformed(turn, tube().positions).astype(np.float32)
    carried = in_body(inputs, bound(inputs).carried(moved))
    assert carried == pytest.approx(transformed(turn, in_body(inputs, inputs.points)), abs=5e-6)


def test_a_frame_allocates_nothing_for_what_bends():
    wrap = bound(carrying())
    moved = tube().positions.astype(np.float32) + np.float32(1.0)
    assert wrap.carried(moved) is wrap.carried(moved)


def test_rigid_pieces_keep_their_shape_to_the_last_digits_far_from_the_origin():
    shift = np.array([100.0, 0.0, 0.0])
    eye = ball((0.0, 0.0, 0.0), 0.02)
    place = motion(shift=(100.5, 0.0, 2.0))
    mesh = SessionMesh(tube().positions + shift, *tube()[1:])
    n = len(eye.positions)
    inputs = carrying(mesh=mesh, place=place, points=eye.positions.astype(np.float32), pieces=np.zeros(n, np.int32))
    bent = tube().positions
    bent[:, 0] += 0.1 * bent[:, 2] ** 2
    carried = bound(inputs).carried((bent + shift).astype(np.float32))
    distances = np.linalg.norm(carried - carried[0], axis=1)
    rest = np.linalg.norm(inputs.points - inputs.points[0], axis=1)
    assert np.abs(carried - inputs.points).max() > 0.1
    assert distances == pytest.approx(rest, abs=1e-7)


def test_the_mirror_image_carries_too():
    """The mesh is the half of a tube at x >= 0, and a point is beside the other half."""
    positions, corners, sizes = tube()
    is_kept = (positions[corners, 0] >= -1e-9).reshape(-1)
    ends = np.cumsum(sizes)
    whole = [np.arange(end - size, end) for end, size in zip(ends, sizes, strict=True)]
    rows = [row for row in whole if is_kept[row].all()]
    used = np.unique(corners[np.concatenate(rows)])
    half = SessionMesh(
        positions[used],
        np.searchsorted(used, corners[np.concatenate(rows)]).astype(np.int32),
        np.array([len(row) for row in rows], np.int32),
    )
    mirror = Mirror(np.diag([-1.0, 1.0, 1.0, 1.0]), 1e-3)
    sides = np.array([[-0.6, 0.0, 1.0], [0.6, 0.0, 1.0]], np.float32)
    inputs = carrying(mesh=half, mirrors=(mirror,), place=np.eye(4), points=sides)
    grown = half.rest_positions * (2.0, 2.0, 1.0)
    carried = bound(inputs).carried(grown.astype(np.float32))
    assert carried[1, 0] > 1.0
    assert carried[0] == pytest.approx(carried[1] * (-1.0, 1.0, 1.0), abs=1e-6)


def test_it_tells_what_needs_another_bind():
    first = carrying(stretch=STRETCH)
    wrap = bound(first)
    assert wrap.is_of(replace(first, stretch=3.0 * STRETCH))
    mesh = first.mesh
    for changes in (
        {"stretch": np.eye(3)},
        {"mirrors": (Mirror(np.diag([-1.0, 1.0, 1.0, 1.0]), 1e-3),)},
        {"points": first.points + np.float32(0.01)},
        {"place": PLACE @ motion(shift=(0.1, 0.0, 0.0))},
        {"pieces": np.zeros(20, np.int32)},
        {"mesh": replace(mesh, rest_positions=mesh.rest_positions * 1.1)},
        {"mesh": replace(mesh, corner_vertices=mesh.corner_vertices[::-1])},
    ):
        assert not wrap.is_of(replace(first, **changes)), changes.keys()


def test_a_bind_that_is_stopped_says_so():
    with pytest.raises(RuntimeError, match=r"^Preparing 'Sleeve' was cancelled; nothing has changed$"):
        run(Wrap.bind(arap_native, carrying()), lambda _: False)


def test_a_vertex_that_is_nowhere_is_told():
    inputs = carrying()
    inputs.points[3, 1] = np.nan
    message = r"^Vertex 3 of 'Sleeve' is at no finite place: repair or remove it$"
    with pytest.raises(ValueError, match=message):
        run(Wrap.bind(arap_native, inputs))
