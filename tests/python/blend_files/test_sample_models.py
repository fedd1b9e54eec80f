# SPDX-License-Identifier: GPL-3.0-or-later
"""The sample models as arrays: what every model in a sample scene must be."""

from pathlib import Path

import numpy as np
import pytest
from scenes.bar import bar, bar_groups
from scenes.cactus import cactus, cactus_groups, flower, pot
from scenes.creature import creature, creature_arrays, creature_groups
from scenes.figure import figure, figure_groups
from scenes.figure_clothes import GAP, belt, buttons, shirt
from scenes.figure_head import eyes, hair, smile
from scenes.quad_mesh import FLIP_X, edges_of, vertex_normals
from scenes.subdivision import catmull_clark, split_by_three

BLEND_FILES = Path(__file__).resolve().parents[3] / "blend_files"
MAKERS = (bar, cactus, creature, figure, flower, pot)


@pytest.fixture(scope="module")
def cub():
    return creature()


@pytest.fixture(scope="module")
def child():
    return figure()


def volume(mesh):
    a, b, c, d = np.moveaxis(mesh.positions[mesh.quads], 1, 0)
    return (np.cross(b, c) + np.cross(c, d)).ravel() @ a.ravel() / 6.0


def check_closed(mesh):
    edges, side_edge = edges_of(mesh.quads)
    assert (np.bincount(side_edge.ravel()) == 2).all(), "an edge has not two faces"
    forwards = mesh.quads < np.roll(mesh.quads, -1, axis=1)
    assert (np.bincount(side_edge[forwards], minlength=len(edges)) == 1).all(), "neighbours face different ways"
    assert volume(mesh) > 0.0


@pytest.mark.parametrize("make", MAKERS, ids=lambda make: make.__name__)
def test_model_is_one_closed_surface_facing_outwards(make):
    mesh = make()
    edges, _ = edges_of(mesh.quads)
    assert len(mesh.positions) - len(edges) + len(mesh.quads) == 2, "not one sphere"
    check_closed(mesh)
    assert np.unique(mesh.quads).size == len(mesh.positions), "a vertex in no face"
    assert np.isfinite(mesh.positions).all()


def test_creature_has_the_size_of_a_sample(cub):
    assert 8_000 <= len(cub.positions) <= 15_000
    low, high = cub.positions.min(axis=0), cub.positions.max(axis=0)
    assert 0.0 <= low[2] < 0.005, "it does not stand on the floor"
    assert 1.5 < high[2] < 2.0


def is_mirror_symmetric(mesh):
    partner = mesh.mirror
    images = np.sort(partner[mesh.quads], axis=1)
    order, image_order = np.lexsort(np.sort(mesh.quads, axis=1).T), np.lexsort(images.T)
    return (
        np.array_equal(partner[partner], np.arange(len(partner)))
        and np.abs(mesh.positions[partner] * FLIP_X - mesh.positions).max() <= 1e-6
        and np.array_equal(np.sort(mesh.quads, axis=1)[order], images[image_order])
    )


def test_creature_is_mirror_symmetric_in_positions_and_faces(cub):
    assert is_mirror_symmetric(cub)
    cub.positions[5, 1] += 1e-5
    try:
        assert not is_mirror_symmetric(cub), "the check cannot fail"
    finally:
        cub.positions[5, 1] -= 1e-5


@pytest.mark.parametrize("refine", [catmull_clark, split_by_three], ids=lambda refine: refine.__name__)
def test_refinement_keeps_symmetry_and_shape(cub, refine):
    finer = refine(cub)
    assert is_mirror_symmetric(finer)
    assert volume(finer) == pytest.approx(volume(cub), rel=0.01)


@pytest.mark.parametrize("n", [50_000, 100_000])
def test_heavier_creature_has_about_the_vertices_asked_for(n):
    positions, corner_vertices, face_sizes = creature_arrays(n)
    assert abs(np.log(len(positions) / n)) < 0.2
    assert positions.dtype == np.float64
    assert corner_vertices.dtype == face_sizes.dtype == np.int32
    assert face_sizes.sum() == len(corner_vertices)
    assert (face_sizes == 4).all()


def test_creature_has_no_needles(cub):
    corners = cub.positions[cub.quads]
    a, b = np.roll(corners, -1, axis=1) - corners, np.roll(corners, 1, axis=1) - corners
    cosine = (a * b).sum(axis=2) / np.linalg.norm(a, axis=2) / np.linalg.norm(b, axis=2)
    angles = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    assert angles.min() > 15.0
    assert angles.max() < 165.0


def test_figure_is_mirror_symmetric(child):
    assert is_mirror_symmetric(child)


@pytest.mark.parametrize("make", [belt, buttons, eyes, smile], ids=lambda make: make.__name__)
def test_what_is_closed_of_the_clothes_faces_outwards(child, make):
    check_closed(make(child))


def test_shirt_is_an_open_sheet_outside_of_the_figure(child):
    worn, covered = shirt(child), child.quads[child.face_data["covered"] == 1]
    under = np.unique(covered)
    away = ((worn.positions - child.positions[under]) * vertex_normals(child)[under]).sum(axis=1)
    assert away.min() > 0.99 * GAP
    assert (face_normals(worn.positions, worn.quads) * face_normals(child.positions, covered)).sum(axis=1).min() > 0.5
    _, side_edge = edges_of(worn.quads)
    assert np.bincount(side_edge.ravel()).min() == 1


def test_hair_is_outside_of_the_head(child):
    cards = hair(child)
    normals, points = vertex_normals(child), child.positions
    head = np.flatnonzero(points[:, 2] > 1.2)
    nearest = head[[np.linalg.norm(points[head] - place, axis=1).argmin() for place in cards.positions]]
    assert ((cards.positions - points[nearest]) * normals[nearest]).sum(axis=1).min() > 0.0


def face_normals(positions, quads):
    a, b, c, d = np.moveaxis(positions[quads], 1, 0)
    normals = np.cross(c - a, d - b)
    return normals / np.linalg.norm(normals, axis=1)[:, None]


def test_creature_groups_are_mirror_images_and_apart(cub):
    groups = creature_groups(cub)
    for name in groups:
        if name.endswith(" L"):
            other = groups[name[:-1] + "R"]
            np.testing.assert_array_equal(np.sort(cub.mirror[groups[name]]), other)
    members = np.concatenate(list(groups.values()))
    assert np.unique(members).size == members.size


@pytest.mark.parametrize(
    ("make", "groups_of"),
    [(bar, bar_groups), (cactus, cactus_groups), (creature, creature_groups), (figure, figure_groups)],
)
def test_groups_leave_most_of_the_model_free(make, groups_of):
    mesh = make()
    sizes = [len(group) for group in groups_of(mesh).values()]
    assert min(sizes) > 100
    assert sum(sizes) < 0.6 * len(mesh.positions)


@pytest.mark.parametrize("name", ["bar", "cactus", "creature", "dressed"])
def test_sample_file_is_small(name):
    assert (BLEND_FILES / f"{name}.blend").stat().st_size < 3_000_000
