# SPDX-License-Identifier: GPL-3.0-or-later
"""Which part of a figure is a limb: of the fox cub, whose parts are known."""

import functools

import numpy as np
import pytest
from arap_deform.core.graph import face_edges
from arap_deform.pull.coarse import RestMesh
from arap_deform.pull.limb import bone_length, border_of, limb_of, root_of
from arap_deform.pull.region import connected_within
from scenes.creature import creature
from scenes.quad_mesh import edges_of

WIDE = 0.12  # of the circle of the mouse; the cub is 1.8 high
PLACES = {"tail": (0.0, 0.8, 1.55), "ear": (0.5, -0.6, 1.75), "paw": (0.2, -0.35, 0.05), "head": (0.0, -0.7, 1.55)}


@functools.cache
def cub(n=12_418):
    mesh = creature(n)
    sizes = np.full(len(mesh.quads), 4, dtype=np.int32)
    return RestMesh(mesh.positions, edges_of(mesh.quads)[0], mesh.quads.ravel(), sizes)


def grip(fine, place, radius=WIDE):
    seed = np.array([np.linalg.norm(fine.points - place, axis=1).argmin()])
    return connected_within(fine.points, fine.edges, seed, fine.points[seed[0]], radius)


def limb(fine, place, radius=WIDE):
    vertices = grip(fine, place, radius)
    root = root_of(fine.coarse, vertices, radius)
    assert root > 0.0
    return limb_of(fine, vertices, root)


def test_the_tail_goes_along_and_nothing_of_the_body():
    points = cub().points
    is_limb = limb(cub(), PLACES["tail"])
    assert is_limb[points[:, 1] > 0.75].all()
    assert not is_limb[points[:, 1] < 0.3].any()


def test_a_leg_goes_along_alone():
    points = cub().points
    is_limb = limb(cub(), PLACES["paw"])
    is_leg = (points[:, 0] > 0.0) & (points[:, 1] < 0.0) & (points[:, 2] < 0.25)
    assert is_limb[is_leg].all()
    assert not is_limb[(points[:, 0] < -0.1) | (points[:, 1] > 0.1) | (points[:, 2] > 0.65)].any()


def test_the_head_takes_its_ears_along():
    points = cub().points
    is_limb = limb(cub(), PLACES["head"])
    assert is_limb[(points[:, 2] > 1.3) & (points[:, 1] < 0.0)].all()
    assert not is_limb[points[:, 1] > 0.05].any()


@pytest.mark.parametrize("place", [(0.0, 1.1, 1.1), (0.0, 0.8, 0.85), (0.1, 1.05, 1.3)])
def test_wherever_it_is_taken_it_is_the_same_limb(place):
    """What is farther out is cut off from the body by the root, and goes along."""
    whole, other = limb(cub(), PLACES["tail"]), limb(cub(), place, 0.08)
    assert (whole != other).sum() < 0.15 * whole.sum()


@pytest.mark.parametrize("part", ["tail", "ear", "paw"])
def test_the_width_of_the_circle_and_the_density_of_the_mesh_do_not_matter(part):
    shares = [limb(fine, PLACES[part], radius).mean() for fine in (cub(), cub(49_666)) for radius in (0.08, 0.16)]
    assert max(shares) < 1.2 * min(shares)


def test_what_is_smaller_than_the_circle_is_no_limb_of_its_own():
    """A circle wider than the ear takes the head."""
    ear, head = (limb(cub(), PLACES["ear"], radius) for radius in (0.08, 0.5))
    assert head.sum() > 4 * ear.sum()


def test_a_skull_and_a_nose_are_no_limbs():
    """A sphere has no narrow place; nor has a cone this blunt on it."""
    turn, height = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False), np.linspace(-1.0, 1.0, 41))
    width = np.sqrt(1.0 - height**2)
    points = np.stack([width * np.cos(turn), width * np.sin(turn), height], axis=-1).reshape(-1, 3)
    i, j = np.meshgrid(np.arange(40), np.arange(60), indexing="ij")
    right = (j + 1) % 60
    corners = np.stack([i * 60 + j, i * 60 + right, i * 60 + 60 + right, i * 60 + 60 + j], axis=-1).astype(np.int32)
    sizes = np.full(40 * 60, 4, dtype=np.int32)
    edges = np.stack(face_edges(corners.ravel(), sizes), axis=1)
    for nose in (1.0, 1.3):
        shape = points * (1.0 + (nose - 1.0) * np.clip(points[:, :1] - 0.7, 0.0, None) / 0.3)
        fine = RestMesh(shape, edges, corners.ravel(), sizes)
        assert root_of(fine.coarse, grip(fine, (nose, 0.0, 0.0), 0.2), 0.2) == 0.0


def test_a_limb_is_as_long_as_its_middle():
    """The tail is curved, and a straight line from its tip to its root is shorter; a way over its skin is longer."""
    fine = cub()
    vertices = grip(fine, PLACES["tail"])
    root = root_of(fine.coarse, vertices, WIDE)
    border = fine.points[border_of(fine, limb_of(fine, vertices, root))]
    assert (np.abs(border[:, 1] - 0.45) < 0.15).all()
    straight = float(np.linalg.norm(fine.points[vertices].mean(axis=0) - border.mean(axis=0)))
    assert straight < bone_length(fine, vertices, root) < root + WIDE


def test_another_piece_of_the_mesh_stays():
    fine = cub()
    n = len(fine.points)
    both = RestMesh(
        np.concatenate([fine.points, fine.points + 0.01]),
        np.concatenate([fine.edges, fine.edges + n]),
        np.concatenate([fine.corner_vertices, fine.corner_vertices + n]),
        np.concatenate([fine.face_sizes, fine.face_sizes]),
    )
    is_limb = limb(both, PLACES["tail"])
    assert is_limb[:n].any() != is_limb[n:].any()


def test_a_mesh_without_faces_has_no_limb():
    none = np.zeros(0, dtype=np.int32)
    fine = RestMesh(np.eye(3), np.array([[0, 1], [1, 2]]), none, none)
    assert root_of(fine.coarse, np.array([0]), 0.1) == 0.0
