# SPDX-License-Identifier: GPL-3.0-or-later
"""When a session no longer fits the scene."""

import dataclasses

import numpy as np
import pytest
from arap_deform.core import session_input
from arap_deform.core.session_data import SessionMesh, SessionSettings
from arap_deform.core.session_input import MeshSignature, SessionInput, VertexConstraint
from arap_deform.core.stiffness import StiffGroup
from arap_deform.core.targets import HandleSpec
from sample_meshes import tube

TUBE = tube()
MESH = SessionMesh(TUBE.positions, TUBE.corner_vertices, TUBE.face_sizes)
COUNTS = (96, 184, 368, 90)


def inputs(mesh=MESH, counts=COUNTS, stretch=None, stiffness=None, regions=None, settings=None):
    return SessionInput(
        object_name="Creature",
        counts=counts,
        mesh=mesh,
        stretch=np.eye(3) if stretch is None else stretch,
        settings=settings or SessionSettings(),
        specs=(HandleSpec("Feet", np.array([0], np.int32), np.ones(1)),),
        constraints=(VertexConstraint("Feet"),),
        signature=MeshSignature.of(mesh, (stiffness, regions)),
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


MESH_CHANGED = "The mesh of 'Creature' has changed (96 vertices and 90 faces, now 97 and 91)"
BIND_CHANGED = (
    "Model, cube size, Keep Volume, bending, rigidity, weights, threads, "
    "Weld Seams or Loose Pieces Follow of 'Creature' have changed"
)
CHANGES = [
    ({"counts": (97, 184, 368, 91)}, MESH_CHANGED),
    ({"mesh": other_diagonal()}, "The faces of 'Creature' have changed"),
    ({"mesh": pushed()}, "The rest shape of 'Creature' has changed"),
    ({"stiffness": np.ones(96)}, "The stiffness of 'Creature' has changed"),
    ({"regions": np.zeros(96, np.int32)}, "The stiffness of 'Creature' has changed"),
    ({"settings": SessionSettings(energy="spokes")}, BIND_CHANGED),
    ({"settings": SessionSettings(model="solid")}, BIND_CHANGED),
    ({"stretch": np.diag([1.0, 1.0, 1.1])}, "The scale of 'Creature' has changed"),
]


@pytest.mark.parametrize(("change", "message"), CHANGES)
def test_what_needs_a_new_bind_says_so(change, message):
    assert session_input.difference_of_bind(inputs(), inputs(**change)) == message


def test_what_needs_none():
    assert session_input.difference_of_bind(inputs(), inputs()) == ""
    assert session_input.difference_of_bind(inputs(), inputs(settings=SessionSettings(accuracy=1e-2))) == ""
    assert session_input.difference_of_bind(inputs(), inputs(stretch=np.eye(3) + 1e-6)) == ""


SCENE_CHANGES = [
    ({"key_name": "Bent"}, "The pose of 'Creature' has another shape key now"),
    ({"counts": (97, 184, 368, 91)}, MESH_CHANGED),
    ({"constraints": (VertexConstraint("Feet", use_exact=False),)}, "The pins or handles of 'Creature' have changed"),
    ({"settings": SessionSettings(rigidity_radius=0.05)}, BIND_CHANGED),
    ({"stiff_groups": (StiffGroup("Armor"),)}, "The stiffness of 'Creature' has changed"),
    ({"stretch": np.diag([1.0, 1.0, 1.1])}, "The scale of 'Creature' has changed"),
]


@pytest.mark.parametrize(("change", "message"), SCENE_CHANGES)
def test_a_frame_says_what_has_changed_in_the_scene(change, message):
    assert session_input.difference_of_scene(inputs(), dataclasses.replace(inputs(), **change)) == message


def test_a_frame_goes_on_if_nothing_has_changed():
    other = dataclasses.replace(inputs(), settings=SessionSettings(accuracy=1e-2), stretch=np.eye(3) + 1e-6)
    assert session_input.difference_of_scene(inputs(), other) == ""


def test_the_same_vertices_held_from_another_place_are_another_hold():
    moved = dataclasses.replace(inputs().specs[0], base=TUBE.positions)
    other = dataclasses.replace(inputs(), specs=(moved,))
    assert session_input.difference(inputs(), inputs()) == ""
    assert session_input.difference(inputs(), other) == "The pins or handles of 'Creature' have changed"
