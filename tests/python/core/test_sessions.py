# SPDX-License-Identifier: GPL-3.0-or-later
"""The registry of live sessions, and when one no longer fits."""

import dataclasses

import numpy as np
import pytest
from arap_deform.core import sessions
from arap_deform.core.session_data import SessionMesh, SessionSettings
from arap_deform.core.sessions import MeshSignature, SessionInput
from arap_deform.core.targets import HandleSpec
from sample_meshes import tube

TUBE = tube()
MESH = SessionMesh(TUBE.positions, TUBE.corner_vertices, TUBE.face_sizes)
COUNTS = (96, 184, 368, 90)


def inputs(mesh=MESH, counts=COUNTS, stretch=None, stiffness=None, regions=None, settings=None):
    return SessionInput(
        object_name="Creature",
        mesh=mesh,
        stretch=np.eye(3) if stretch is None else stretch,
        settings=settings or SessionSettings(),
        specs=(HandleSpec("Feet", np.array([0], np.int32), np.ones(1)),),
        holds=(("Feet", True),),
        signature=MeshSignature.of(counts, mesh, (stiffness, regions)),
        stiffness=stiffness,
        rigid_regions=regions,
    )


def other_diagonal():
    """The same counts, but one quad starts elsewhere and runs the other way."""
    corners = TUBE.corner_vertices.copy()
    corners[:4] = corners[3::-1]
    return dataclasses.replace(MESH, corner_vertices=corners)


def pushed():
    positions = TUBE.positions.copy()
    positions[5] += 0.01
    return dataclasses.replace(MESH, rest_positions=positions)


CHANGES = [
    ({"counts": (97, 184, 368, 91)}, "The mesh of 'Creature' has changed (96 vertices and 90 faces, now 97 and 91)"),
    ({"mesh": other_diagonal()}, "The faces of 'Creature' have changed"),
    ({"mesh": pushed()}, "The rest shape of 'Creature' has changed"),
    ({"stiffness": np.ones(96)}, "The stiffness of 'Creature' has changed"),
    ({"regions": np.zeros(96, np.int32)}, "The stiffness of 'Creature' has changed"),
    (
        {"settings": SessionSettings(energy="spokes")},
        "Energy, rigidity, weights, threads or seams of 'Creature' have changed",
    ),
    ({"stretch": np.diag([1.0, 1.0, 1.1])}, "The scale of 'Creature' has changed"),
]


@pytest.mark.parametrize(("change", "message"), CHANGES)
def test_what_needs_a_new_bind_says_so(change, message):
    assert sessions.difference_of_bind(inputs(), inputs(**change)) == message


def test_what_needs_none():
    assert sessions.difference_of_bind(inputs(), inputs()) == ""
    assert sessions.difference_of_bind(inputs(), inputs(settings=SessionSettings(accuracy=1e-2))) == ""
    assert sessions.difference_of_bind(inputs(), inputs(stretch=np.eye(3) + 1e-6)) == ""


def test_registry_forgets_what_is_missing():
    sessions.clear()
    for name in ("Creature", "Gone"):
        sessions.put(name, sessions.Bound(session=object(), inputs=inputs()))
        sessions.set_readout(name, "readout")
    sessions.set_readout("Gone too", "readout")
    sessions.forget_missing(lambda name: name == "Creature")
    assert [sessions.get(name) is None for name in ("Creature", "Gone")] == [False, True]
    assert [sessions.readout(name) for name in ("Creature", "Gone", "Gone too")] == ["readout", None, None]


def test_registry_forgets_sessions_but_keeps_readouts_until_a_file_load():
    sessions.clear()
    bound = sessions.Bound(session=object(), inputs=inputs())
    sessions.put("Creature", bound)
    sessions.set_readout("Creature", "readout")
    assert sessions.get("Creature") is bound
    sessions.drop("Creature")
    sessions.drop("Nobody")
    assert sessions.get("Creature") is None
    assert sessions.readout("Creature") == "readout"
    sessions.clear()
    assert sessions.readout("Creature") is None
