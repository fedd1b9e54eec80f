# SPDX-License-Identifier: GPL-3.0-or-later
"""What the binds of several attachments to one mesh share."""

from dataclasses import replace

import arap_native
import numpy as np
import pytest
from arap_deform.core.attach.surface import PreparedSurface
from arap_deform.core.attach.wrap import Wrap
from arap_deform.core.attach.wrap_input import WrapInput
from arap_deform.core.background import Cancelled, run
from arap_deform.core.mirror import Mirror
from arap_deform.core.session_data import SessionMesh
from sample_meshes import tube


def carrying(name: str = "Sleeve", scale: float = 1.2) -> WrapInput:
    points = (tube().positions[20:40] * (scale, scale, 1.0)).astype(np.float32)
    return WrapInput(name=name, mesh=SessionMesh(*tube()), stretch=np.eye(3), points=points, place=np.eye(4))


def test_followers_of_one_mesh_share_it():
    prepared = PreparedSurface()
    button = carrying("Button", scale=1.1)
    kept = run(prepared.of(arap_native, carrying()))
    assert run(prepared.of(arap_native, button)) is kept
    moved = tube().positions.astype(np.float32) ** 2
    alone = run(Wrap.bind(arap_native, button)).carried(moved)
    assert np.array_equal(run(Wrap.bind(arap_native, button, prepared)).carried(moved), alone)


def test_another_shape_stretch_or_mirror_needs_another():
    first = carrying()
    moved = replace(first.mesh, rest_positions=first.mesh.rest_positions * 1.1)
    mirror = Mirror(np.diag([-1.0, 1.0, 1.0, 1.0]), 1e-3)
    for changes in ({"mesh": moved}, {"stretch": np.diag([1.0, 2.0, 1.0])}, {"mirrors": (mirror,)}):
        prepared = PreparedSurface()
        kept = run(prepared.of(arap_native, first))
        assert run(prepared.of(arap_native, replace(first, **changes))) is not kept, changes.keys()


def test_it_is_kept_until_it_is_dropped():
    prepared = PreparedSurface()
    kept = run(prepared.of(arap_native, carrying()))
    prepared.drop()
    assert run(prepared.of(arap_native, carrying())) is not kept


def test_after_one_that_was_stopped_the_next_bind_prepares_it():
    prepared = PreparedSurface()
    with pytest.raises(Cancelled, match=r"^Preparing 'Sleeve' was cancelled; nothing has changed$"):
        run(prepared.of(arap_native, carrying()), lambda _: False)
    surface, ready = run(prepared.of(arap_native, carrying()))
    assert len(surface.rest) == ready.n_vertices == len(tube().positions)
