# SPDX-License-Identifier: GPL-3.0-or-later
"""A session of a mesh in a cage, with the real module, without Blender."""

import arap_native
import numpy as np
import pytest
from arap_deform.core import sessions
from arap_deform.core.background import Background, run
from arap_deform.core.cages.session import Cage, CageSession
from arap_deform.core.mirror import Mirror
from arap_deform.core.session_data import SessionMesh, SessionSettings
from arap_deform.core.session_input import CageHold, MeshSignature, SessionInput, difference, difference_of_scene
from arap_deform.core.transforms import stretch_of
from sample_meshes import tube

TUBE = tube()
MESH = SessionMesh(TUBE.positions, TUBE.corner_vertices, TUBE.face_sizes)
PLACES, QUADS = arap_native.make_cage(TUBE.positions, TUBE.corner_vertices, TUBE.face_sizes, 4)
AROUND = SessionMesh(PLACES, QUADS.ravel(), np.full(len(QUADS), 4, dtype=np.int32))
CAGE = Cage("Cage", AROUND, "mean_value")
STRETCH = np.diag([1.0, 3.0, 0.5])
SHEAR = np.array([[1.0, 0.3, 0.0], [0.0, 1.2, 0.0], [0.1, 0.0, 0.8]])


def new_session(stretch=None, cage=CAGE, **options):
    settings = SessionSettings()
    return run(
        CageSession.bind(arap_native, MESH, np.eye(3) if stretch is None else stretch, settings, cage, **options)
    )


@pytest.mark.parametrize("stretch", [np.eye(3), stretch_of(STRETCH)], ids=["unscaled", "scaled"])
@pytest.mark.parametrize("coordinates", ["mean_value", "harmonic"])
def test_an_affine_motion_of_the_cage_is_that_of_the_mesh(stretch, coordinates):
    session = new_session(stretch, Cage("Cage", AROUND, coordinates))
    positions = session.positions
    readout = session.update(AROUND.rest_positions @ SHEAR.T + 1.0)
    assert session.positions is positions
    assert (readout.stop_reason, readout.vertices, readout.free_vertices) == ("converged", len(positions), 0)
    np.testing.assert_allclose(positions, TUBE.positions @ SHEAR.T + 1.0, atol=2e-6)
    session.reset()
    np.testing.assert_array_equal(positions, TUBE.positions.astype(np.float32))


def test_green_coordinates_keep_shapes_as_seen():
    """A quarter turn as seen, of an object that is stretched: no shear as seen."""
    stretch = stretch_of(STRETCH)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    in_object = np.linalg.inv(stretch) @ turn @ stretch
    session = new_session(stretch, Cage("Cage", AROUND, "green"))
    session.update(AROUND.rest_positions @ in_object.T)
    np.testing.assert_allclose(session.positions, TUBE.positions @ in_object.T, atol=2e-5)


def test_the_base_is_where_the_mesh_is_while_the_cage_is_at_rest():
    base = TUBE.positions + np.array([0.0, 0.05, 0.0])
    session = new_session(cage=Cage("Cage", AROUND, "mean_value", base))
    session.update(AROUND.rest_positions)
    np.testing.assert_allclose(session.positions, base, atol=1e-6)


def test_vertices_of_half_a_mesh_stay_on_the_mirror_plane():
    flip = np.diag([1.0, 1.0, -1.0, 1.0])
    session = new_session(mirrors=(Mirror(flip, 1e-4),))
    session.update(AROUND.rest_positions + np.array([1.0, 0.0, 0.5]))
    expected = TUBE.positions + np.array([1.0, 0.0, 0.5])
    expected[TUBE.positions[:, 2] == 0.0, 2] = 0.0
    np.testing.assert_allclose(session.positions, expected, atol=1e-6)


def test_what_is_shown_can_be_set_and_a_refused_update_leaves_it():
    session = new_session()
    session.set_positions(TUBE.positions + 1.0)
    shown = session.positions.copy()
    with pytest.raises(ValueError, match="cage_positions"):
        session.update(AROUND.rest_positions[1:])
    with pytest.raises(ValueError, match="beyond the range of single precision"):
        session.update(AROUND.rest_positions + 1e39)
    with pytest.raises(ValueError, match=r"^positions have shape \(3, 3\), expected \(96, 3\)$"):
        session.set_positions(np.eye(3))
    np.testing.assert_array_equal(session.positions, shown)


def test_a_cage_that_does_not_fit_says_its_name():
    with pytest.raises(ValueError, match=r"^Cage 'Cage' cannot move the mesh: 96 of 96 points are not inside of"):
        new_session(cage=Cage("Cage", SessionMesh(AROUND.rest_positions + 9.0, *faces()), "harmonic"))


def faces():
    return AROUND.corner_vertices, AROUND.face_sizes


def inputs(hold, cage=CAGE):
    return SessionInput(
        object_name="Tube",
        counts=(96, 0, 0, 0),
        stretch=np.eye(3),
        settings=SessionSettings(),
        holds=(hold,),
        mesh=MESH,
        specs=(),
        signature=MeshSignature.of(MESH, ()),
        cage=cage,
    )


def test_another_cage_needs_a_bind_and_the_same_one_keeps_the_session():
    hold = CageHold("Cage", "mean_value", 1, 2)
    first = run(sessions.rebuild(inputs(hold), None))
    assert isinstance(first, CageSession)
    bound = sessions.Bound(first, inputs(hold))
    assert run(sessions.rebuild(inputs(hold), bound)) is first
    for other in (
        CageHold("Cage", "green", 1, 2),
        CageHold("Cage", "mean_value", 3, 2),
        CageHold("Cage", "mean_value", 1, 4),
        CageHold("Cage", "mean_value", 1, 2, 5),
    ):
        assert difference(bound.inputs, inputs(other)) == "The cage of 'Tube' has changed"
        assert difference_of_scene(bound.inputs, inputs(other)) == "The pins or handles of 'Tube' have changed"
        assert run(sessions.rebuild(inputs(other), bound)) is not first


def test_a_dropped_bind_ends():
    work = Background(CageSession.bind(arap_native, MESH, np.eye(3), SessionSettings(), CAGE))
    work.drop()
    assert work.is_done
