# SPDX-License-Identifier: GPL-3.0-or-later
"""From the entries of the list Stiffness to stiffness and rigid regions."""

import numpy as np
import pytest
from arap_deform.core.session import SessionMesh
from arap_deform.core.stiffness import StiffGroup, regions_of, stiffness_of
from sample_meshes import tube

TUBE = tube()
MESH = SessionMesh(TUBE.positions, TUBE.corner_vertices, TUBE.face_sizes)
Z = TUBE.positions[:, 2]


def rigid(name, **options):
    return StiffGroup(name, use_rigid=True, **options)


def test_each_step_of_weight_multiplies():
    weights = {"Soft": np.array([0.0, 0.5, 1.0, 2.0])}
    np.testing.assert_allclose(stiffness_of([StiffGroup("Soft")], weights), [1.0, 10.0, 100.0, 100.0])
    np.testing.assert_allclose(stiffness_of([StiffGroup("Soft", factor=4.0)], weights), [1.0, 2.0, 4.0, 4.0])


def test_a_vertex_in_several_entries_takes_the_largest_stiffness():
    weights = {"Soft": np.array([1.0, 0.5, 0.0]), "Stiff": np.array([0.0, 0.5, 1.0])}
    entries = [StiffGroup("Soft", factor=4.0), StiffGroup("Stiff", factor=25.0)]
    np.testing.assert_allclose(stiffness_of(entries, weights), [4.0, 5.0, 25.0])


def test_rigid_entries_are_not_stiff_and_stiff_ones_not_rigid():
    weights = {"Group": np.ones(len(Z))}
    assert stiffness_of([rigid("Group")], weights) is None
    assert regions_of([StiffGroup("Group")], weights, MESH) is None
    assert stiffness_of([], {}) is None
    assert regions_of([], {}, MESH) is None


def test_regions_are_the_connected_pieces_of_weights_from_one_half_on():
    weights = {"Ends": np.where(Z < 1.0, 1.0, np.where(Z > 3.0, 0.5, 0.49))}
    regions = regions_of([rigid("Ends")], weights, MESH)
    assert len(set(regions[Z < 1.0])) == len(set(regions[Z > 3.0])) == 1
    assert regions[0] != regions[-1]
    assert min(regions[0], regions[-1]) >= 0
    assert set(regions[(Z >= 1.0) & (Z <= 3.0)]) == {-1}
    assert regions.dtype == np.int32


def test_one_body_takes_pieces_that_are_not_joined():
    weights = {"Ends": ((Z < 1.0) | (Z > 3.0)).astype(float)}
    regions = regions_of([rigid("Ends", use_single_body=True)], weights, MESH)
    assert len(set(regions[weights["Ends"] > 0.0])) == 1
    assert regions[0] >= 0
    assert set(regions[weights["Ends"] == 0.0]) == {-1}


@pytest.mark.parametrize(("upper_from", "n_bodies"), [(2.1, 2), (1.5, 1)])
def test_entries_side_by_side_are_two_bodies_and_one_if_they_overlap(upper_from, n_bodies):
    weights = {"Lower": (Z < 2.1).astype(float), "Upper": (upper_from < Z).astype(float)}
    regions = regions_of([rigid("Lower"), rigid("Upper")], weights, MESH)
    use_rigid = np.maximum(*weights.values()) > 0.0
    assert (regions[use_rigid] >= 0).all()
    assert len(set(regions[use_rigid])) == n_bodies


def test_an_entry_without_weights_is_no_body():
    weights = {"None": np.zeros(len(Z)), "Lower": (Z < 2.0).astype(float)}
    for use_single_body in (False, True):
        regions = regions_of([rigid("None", use_single_body=use_single_body), rigid("Lower")], weights, MESH)
        assert len(set(regions[Z < 2.0])) == 1
        assert regions[0] >= 0
        assert set(regions[Z >= 2.0]) == {-1}
