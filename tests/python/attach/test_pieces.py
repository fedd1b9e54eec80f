# SPDX-License-Identifier: GPL-3.0-or-later
"""Loose pieces of an attached object, and which look rigid."""

import numpy as np
import pytest
from arap_deform.core.attach.pieces import looks_rigid, loose_pieces
from sample_meshes import Mesh, ball, joined, sheet, tube

SIZE = 4.0  # of what carries


def scaled(mesh: Mesh, *factors: float) -> Mesh:
    return mesh._replace(positions=mesh.positions * np.array(factors))


def test_pieces_are_what_edges_connect():
    pieces = loose_pieces(5, np.array([[1, 3], [3, 4]], dtype=np.int32))
    assert pieces.dtype == np.int32
    assert (pieces == [0, 1, 2, 1, 1]).all()


def part(mesh: Mesh, low: float, high: float = np.inf) -> Mesh:
    """The faces between two heights."""
    rows = np.split(mesh.corner_vertices, np.cumsum(mesh.face_sizes)[:-1])
    is_in = (mesh.positions[:, 2] >= low) & (mesh.positions[:, 2] <= high)
    kept = [row for row in rows if is_in[row].all()]
    return Mesh(mesh.positions, np.concatenate(kept), np.array([len(row) for row in kept], np.int32))


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [
        (joined(ball((0, 0, 0), 0.1), ball((1, 0, 0), 0.05)), True),
        (scaled(ball((0, 0, 0), 0.2), 1.0, 1.0, 0.3), True),
        (ball((0, 0, 0), 1.0), False),
        (joined(ball((0, 0, 0), 0.1), scaled(sheet(4), 0.1, 0.1, 1.0)), False),
        (scaled(tube(), 0.1, 0.1, 0.001), True),
        (joined(ball((0, 0, 0), 0.1), part(ball((1, 0, 0), 0.1, rings=16), -0.015)), True),
        (part(ball((0, 0, 0), 0.1, rings=16), -0.05, 0.05), False),
        (part(scaled(ball((0, 0, 0), 0.1), 1.0, 0.3, 1.0), -0.05), False),
        (part(scaled(tube(), 0.1, 0.1, 0.1), 0.1), False),
    ],
    ids=[
        "eyes",
        "a button",
        "too large",
        "a card beside an eye",
        "a coin",
        "half an eye",
        "a cuff",
        "a flat purse",
        "a finger of a glove",
    ],
)
def test_small_compact_pieces_look_rigid(mesh, expected):
    assert looks_rigid(*mesh, SIZE) is expected


def test_points_and_a_flat_closed_mesh_do_not():
    assert not looks_rigid(np.zeros((3, 3)), np.zeros(0, np.int32), np.zeros(0, np.int32), SIZE)
    flat = scaled(ball((0, 0, 0), 0.1), 1.0, 1.0, 0.0)
    assert not looks_rigid(*flat, SIZE)


def ring(thick: float, high: float) -> Mesh:
    """Closed, of radius 0.3, with four sides all around."""
    angle = np.arange(24) * (2 * np.pi / 24)
    around = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    outer, inner = 0.3 * around, (0.3 - thick) * around
    up = np.array([0, 0, high])
    positions = np.concatenate([outer, outer + up, inner + up, inner])
    side = np.arange(24)
    quads = [
        np.stack([24 * a + side, 24 * a + (side + 1) % 24, 24 * b + (side + 1) % 24, 24 * b + side], axis=1)
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))
    ]
    faces = np.concatenate(quads).astype(np.int32)
    return Mesh(positions, faces.ravel(), np.full(len(faces), 4, np.int32))


@pytest.mark.parametrize(
    ("mesh", "expected"),
    [(ring(0.01, 0.1), False), (ring(0.03, 0.1), False), (ring(0.12, 0.1), True)],
    ids=["a bracelet of cloth", "a belt", "a button with a hole"],
)
def test_rings_look_rigid_if_they_are_thick(mesh, expected):
    assert looks_rigid(*mesh, SIZE) is expected
