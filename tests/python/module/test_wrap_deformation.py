# SPDX-License-Identifier: GPL-3.0-or-later
"""WrapDeformation from the outside: arrays in and out, options, jobs, errors. What it computes: tests/native."""

import arap_native
import numpy as np
import pytest
from arap_native import WrapDeformation, WrapOptions, WrapSurface
from numpy.typing import NDArray
from sample_meshes import rotation_z, tube


def points_around(n: int = 20) -> NDArray[np.float64]:
    rest = tube().positions
    return rest[:n] + np.random.default_rng(1).uniform(-0.2, 0.2, (n, 3))


def moved_tube() -> NDArray[np.float64]:
    rest = tube().positions
    return rest + 0.1 * rest[:, ::-1] ** 2


def test_points_turn_with_the_surface():
    wrap = WrapDeformation(points_around(), *tube())
    assert wrap.deform(tube().positions) == pytest.approx(points_around(), abs=1e-14)
    turned = 2 * tube().positions @ rotation_z(1.0).T + 3
    assert wrap.deform(turned) == pytest.approx(2 * points_around() @ rotation_z(1.0).T + 3, abs=1e-12)
    assert (wrap.n_points, wrap.n_vertices, wrap.n_pieces) == (20, len(tube().positions), 0)
    assert repr(wrap) == f"<WrapDeformation: 20 points, {len(tube().positions)} vertices of the surface, 1 thread>"


def test_a_surface_without_faces_carries_too():
    wrap = WrapDeformation(points_around(), tube().positions, np.empty((0, 3), np.int32))
    assert wrap.deform(tube().positions + 1.0) == pytest.approx(points_around() + 1.0, abs=1e-12)


def test_pieces_stay_rigid():
    pieces = np.repeat([-1, 4], 10)
    wrap = WrapDeformation(points_around(), *tube(), piece_of_point=pieces)
    assert wrap.n_pieces == 1
    rigid, rest = wrap.deform(moved_tube())[10:], points_around()[10:]
    assert np.linalg.norm(rigid - rigid[0], axis=1) == pytest.approx(np.linalg.norm(rest - rest[0], axis=1), abs=1e-12)


def test_out_takes_the_result():
    wrap = WrapDeformation(points_around(), *tube())
    out = np.empty((20, 3), np.float32)
    assert wrap.deform(moved_tube(), out=out) is out
    assert np.array_equal(out, wrap.deform(moved_tube()).astype(np.float32))
    with pytest.raises(ValueError, match=r"^out has shape \(2, 3\), expected \(20, 3\): one row per point"):
        wrap.deform(moved_tube(), out=np.empty((2, 3), np.float32))


def test_a_job_does_what_the_constructor_does():
    pieces = np.repeat([-1, 4], 10)
    wrap = WrapDeformation.begin_bind(points_around(), *tube(), piece_of_point=pieces).result()
    assert type(wrap) is WrapDeformation
    expected = WrapDeformation(points_around(), *tube(), piece_of_point=pieces).deform(moved_tube())
    assert np.array_equal(wrap.deform(moved_tube()), expected)


def test_binds_share_a_surface():
    pieces = np.repeat([-1, 4], 10)
    options = WrapOptions(anchors=5)
    expected = WrapDeformation(points_around(), *tube(), options=options, piece_of_point=pieces).deform(moved_tube())
    for surface in (WrapSurface(*tube()), WrapSurface.begin_prepare(*tube(), threads=2).result()):
        assert type(surface) is WrapSurface
        assert repr(surface) == f"<WrapSurface: {len(tube().positions)} vertices>"
        assert surface.n_vertices == len(tube().positions)
        wrap = surface.bind(points_around(), options=options, piece_of_point=pieces)
        job = surface.begin_bind(points_around(), options=options, piece_of_point=pieces)
        del surface  # neither needs it any more
        for bound in (wrap, job.result()):
            assert np.array_equal(bound.deform(moved_tube()), expected)


def test_threads_bind_to_one_surface_at_once():
    surface = WrapSurface(*tube())
    expected = surface.bind(points_around()).deform(moved_tube())
    jobs = [surface.begin_bind(points_around()) for _ in range(8)]
    assert all(np.array_equal(job.result().deform(moved_tube()), expected) for job in jobs)


def test_single_precision_may_go_in_and_out():
    wrap, moved = WrapDeformation(points_around(), *tube()), moved_tube().astype(np.float32)
    expected = wrap.deform(moved).astype(np.float32)
    for given in (moved, np.asfortranarray(moved), np.ma.array(moved)):
        out = np.empty_like(expected)
        wrap.deform(given, out=out)
        np.testing.assert_array_equal(out, expected)


def test_progress_is_told():
    told: list[float] = []
    surface = WrapSurface(*tube(), progress=told.append)
    assert told.pop() == 1
    surface.bind(points_around(), progress=told.append)
    assert told.pop() == 1
    WrapDeformation(points_around(), *tube(), progress=told.append)
    assert told.pop() == 1


def test_options_are_named_values():
    assert repr(WrapOptions()) == "WrapOptions(anchors=12, stay_outside=True, threads=0)"
    assert WrapDeformation(points_around(), *tube(), options=WrapOptions(threads=2)).threads == 2
    with pytest.raises(ValueError, match=r"^anchors = 0, must be "):
        WrapOptions(anchors=0)


def test_what_is_wrong_is_told_in_words():
    with pytest.raises(ValueError, match=r"^points has shape \(3,\), expected \(n, 3\): one row per point"):
        WrapDeformation(np.zeros(3), *tube())
    with pytest.raises(ValueError, match=r"^piece_of_point has shape \(2,\), expected \(20,\): one number per point"):
        WrapDeformation(points_around(), *tube(), piece_of_point=[0, 1])
    wrap = WrapDeformation(points_around(), *tube())
    with pytest.raises(ValueError, match=r"^surface_positions has shape \(20, 3\), expected \(\d+, 3\): one row per"):
        wrap.deform(points_around())
    with pytest.raises(ValueError, match=r"^threads = -1, must be 0 "):
        WrapSurface(*tube(), threads=-1)
    with pytest.raises(arap_native.Cancelled):
        WrapSurface(*tube(), progress=lambda _: False)
    with pytest.raises(arap_native.Cancelled):
        WrapSurface(*tube()).bind(points_around(), progress=lambda _: False)
    with pytest.raises(arap_native.Cancelled):
        WrapDeformation(points_around(), *tube(), progress=lambda _: False)
