# SPDX-License-Identifier: GPL-3.0-or-later
"""Every long call tells how far it is, up to 1, and ends where its progress says so, or raises."""

import inspect
from collections.abc import Callable
from typing import Any

import arap_native
import numpy as np
import pytest
from sample_meshes import ends, tube

MESH = tube()
VERTICES = ends(MESH)
CAGE = arap_native.make_cage(*MESH, cells=4)
TETS = arap_native.LatticeTets(*MESH, cube_size=0.2)

CALLS: dict[str, Callable[..., Any]] = {
    "SurfaceArap": lambda **given: arap_native.SurfaceArap(*MESH, **given),
    "LatticeArap": lambda **given: arap_native.LatticeArap(*MESH, **given),
    "PoissonEditing": lambda **given: arap_native.PoissonEditing(*MESH, **given),
    "EmbeddedDeformation": lambda **given: arap_native.EmbeddedDeformation(*MESH, **given),
    "CageArap": lambda **given: arap_native.CageArap(*MESH, cage=CAGE, **given),
    "TetArap": lambda **given: arap_native.TetArap(TETS.rest_positions, TETS.tets, **given),
    "Model.set_constraints": lambda **given: arap_native.SurfaceArap(*MESH).set_constraints(VERTICES, **given),
    "Model.solve": lambda **given: held().solve(MESH.positions[VERTICES] * 1.1, **given),
    "LatticeTets": lambda **given: arap_native.LatticeTets(*MESH, **given),
    "CageDeformation": lambda **given: arap_native.CageDeformation(MESH.positions, *CAGE, **given),
    "CageDeformation.fit": lambda **given: arap_native.CageDeformation(MESH.positions, *CAGE).fit(
        MESH.positions, **given
    ),
    "WrapSurface": lambda **given: arap_native.WrapSurface(*MESH, **given),
    "WrapSurface.bind": lambda **given: arap_native.WrapSurface(*MESH).bind(MESH.positions, **given),
    "WrapDeformation": lambda **given: arap_native.WrapDeformation(MESH.positions, *MESH, **given),
    "make_cage": lambda **given: arap_native.make_cage(*MESH, **given),
    "transfer_cage": lambda **given: arap_native.transfer_cage(CAGE, CAGE[0], CAGE, **given),
    "same_places": lambda **given: arap_native.same_places(*MESH, **given),
}


def held() -> arap_native.SurfaceArap:
    model = arap_native.SurfaceArap(*MESH)
    model.set_constraints(VERTICES)
    return model


class Boom(Exception):
    pass


def test_all_that_take_progress_are_here():
    found = set()
    for name in arap_native.__all__:
        member = getattr(arap_native, name)
        members = {name: member} if callable(member) else {}
        if inspect.isclass(member):
            members |= {f"{name}.{key}": getattr(member, key) for key in vars(member) if not key.startswith("_")}
        for key, function in members.items():
            try:
                parameters = inspect.signature(function).parameters
            except (TypeError, ValueError):
                continue
            found |= {key} if "progress" in parameters else set()
    assert found == set(CALLS)


@pytest.mark.parametrize("name", CALLS)
def test_fractions_rise_to_one(name):
    told: list[float] = []
    CALLS[name](progress=told.append)
    assert told == sorted(told)
    assert told[0] >= 0
    assert told[-1] == 1


@pytest.mark.parametrize("name", CALLS)
def test_what_progress_says_ends_the_call(name):
    def boom(_fraction: float) -> None:
        raise Boom

    with pytest.raises(Boom):
        CALLS[name](progress=boom)
    if name == "Model.solve":
        assert CALLS[name](progress=lambda _: False).stop_reason == "cancelled"
    else:
        with pytest.raises(arap_native.Cancelled, match="was cancelled"):
            CALLS[name](progress=lambda _: False)


def test_a_cancelled_call_is_no_failure_of_the_solver():
    """What tells them apart is the class."""
    assert issubclass(arap_native.Cancelled, RuntimeError)
    with pytest.raises(RuntimeError) as caught:
        arap_native.SurfaceArap(MESH.positions * 1e-80, *MESH[1:]).energy(MESH.positions * [1e90, 2e90, 3e90])
    assert caught.type is RuntimeError


def test_progress_of_a_fit_may_fit():
    cage = arap_native.CageDeformation(MESH.positions, *CAGE)
    inner = []
    outer = cage.fit(MESH.positions, progress=lambda _: inner.append(cage.fit(MESH.positions)))
    assert all(np.array_equal(one, outer) for one in inner)
