# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a few vertices of an attached object and its mesh say the same as before."""

from dataclasses import replace

import numpy as np
import pytest
from arap_deform.core.attach.probe import MOST, Probe, probed
from arap_deform.core.transforms import transformed
from sample_meshes import rotation_z

PLACE = np.eye(4)
PLACE[:3] = np.column_stack([rotation_z(0.5) * (1.0, 2.0, 1.0), (3.0, 0.0, 1.0)])
MAP = np.eye(4)
MAP[:3] = np.column_stack([rotation_z(1.0) * (0.5, 1.0, 3.0), (0.0, 7.0, 0.0)])
RANDOM = np.random.default_rng(3)
PROBE = Probe(
    points=RANDOM.uniform(size=(MOST, 3)).astype(np.float32),
    surface=RANDOM.uniform(size=(MOST, 3)).astype(np.float32),
    place=PLACE,
)


def mapped(matrix, points):
    return transformed(matrix, points.astype(np.float64)).astype(np.float32)


def test_few_vertices_are_looked_at_the_ends_among_them():
    assert probed(3) == [0, 1, 2]
    assert (len(probed(1000)), probed(1000)[0], probed(1000)[-1]) == (MOST, 0, 999)


def test_each_array_counts():
    assert PROBE.is_same(replace(PROBE))
    for field in ("points", "surface", "place"):
        assert not PROBE.is_same(replace(PROBE, **{field: getattr(PROBE, field) + np.float32(1e-3)})), field


@pytest.mark.parametrize("of_points", [np.eye(4), MAP], ids=["", "attachment"])
@pytest.mark.parametrize("of_surface", [np.eye(4), MAP @ MAP], ids=["", "host"])
def test_maps_that_the_place_makes_up_for_are_applied(of_points, of_surface):
    now = Probe(
        points=mapped(of_points, PROBE.points),
        surface=mapped(of_surface, PROBE.surface),
        place=of_surface @ PLACE @ np.linalg.inv(of_points),
    )
    assert PROBE.is_applied(now)
    assert not PROBE.is_applied(replace(now, place=MAP @ now.place))
    assert not PROBE.is_applied(replace(now, points=now.points * (1.0, 1.0, 1.01)))
