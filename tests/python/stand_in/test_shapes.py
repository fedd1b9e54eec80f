# SPDX-License-Identifier: GPL-3.0-or-later
"""The arrays of a stand-in: several meshes as one, with fewer vertices, with finer edges, connected."""

import numpy as np
import pytest
from arap_deform.core.stand_in.bridges import connected
from arap_deform.core.stand_in.fewer import simplified
from arap_deform.core.stand_in.finer import split_edges
from arap_deform.core.stand_in.shape import Shape, centre_of, clustered, joined, parts_of, triangles_of


def grid(n, z=0.0, size=1.0, weight=0.0):
    """A square of (n, n) vertices in the plane at z, with one group."""
    x, y = np.meshgrid(np.linspace(0, size, n), np.linspace(0, size, n), indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), np.full(n * n, z)])
    i = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
    triangles = np.concatenate([np.stack([i, i + n, i + n + 1], 1), np.stack([i, i + n + 1, i + 1], 1)])
    return Shape(points, triangles, np.full((1, n * n), weight, dtype=np.float32))


def moved(shape, *shift):
    return Shape(shape.points + np.array(shift), shape.triangles, shape.weights)


def fields(shape):
    return shape.triangles, shape.weights


def longest(shape):
    ends = shape.points[shape.triangles] - shape.points[np.roll(shape.triangles, 1, axis=1)]
    return np.linalg.norm(ends, axis=2).max()


def result_of(steps):
    def kept():
        found.append((yield from steps))

    found = []
    assert all(step is None for step in kept())
    return found[0]


def n_parts(shape):
    return len(np.unique(parts_of(shape)))


def test_joined_without_loose_vertices():
    loose = Shape(np.array([[9.0, 9.0, 9.0]]), np.empty((0, 3), dtype=np.int64), np.ones((1, 1), dtype=np.float32))
    shape = joined([grid(2, weight=0.25), loose, grid(3, z=1.0, weight=0.5)])
    assert shape.points.shape == (13, 3)
    np.testing.assert_array_equal(shape.weights[0], [0.25] * 4 + [0.5] * 9)
    assert n_parts(shape) == 2
    np.testing.assert_allclose(shape.area, 2.0)


def test_faces_are_fans():
    corners = np.array([0, 1, 2, 3, 4, 4, 3, 5], dtype=np.int32)
    triangles = triangles_of(corners, np.array([5, 3], dtype=np.int32))
    np.testing.assert_array_equal(triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4], [4, 3, 5]])
    np.testing.assert_array_equal(triangles_of(corners[5:], np.array([3], dtype=np.int32)), [[4, 3, 5]])


def test_the_centre_is_what_most_is_symmetric_about():
    body = moved(grid(11), -0.5, 3.0, 1.0)
    sword = moved(grid(4), 1.0, 3.2, 1.0)
    np.testing.assert_allclose(centre_of(body), (0.0, 3.5, 1.0), atol=1e-12)
    np.testing.assert_allclose(centre_of(joined([body, sword])), (0.0, 3.6, 1.0), atol=1e-12)
    aside = moved(body, 0.2, 0.0, 0.0)
    np.testing.assert_allclose(centre_of(aside), (0.2, 3.5, 1.0), atol=1e-12)


def test_seams_are_closed_and_nothing_else_changes():
    shape = joined([grid(4, weight=0.25), moved(grid(4), 1.0, 0.0, 0.0)])
    closed = result_of(simplified(shape, 1000))
    assert (len(closed.points), n_parts(closed)) == (28, 1)
    assert {tuple(p) for p in closed.points} == {tuple(p) for p in shape.points}
    np.testing.assert_allclose(closed.area, 2.0)
    assert (closed.weights[0] == 0.25).sum() == 16, "the larger weight counts at the seam"


@pytest.mark.parametrize("most", [200, 1000, 5000])
def test_no_more_vertices_than_may_stay_and_not_far_fewer(most):
    rng = np.random.default_rng(0)
    flat = grid(150)
    shape = Shape(flat.points + 0.1 * np.sin(9 * flat.points[:, ::-1]), flat.triangles, rng.random((1, 22500), "f4"))
    few = result_of(simplified(shape, most))
    assert 0.5 * most < len(few.points) <= most
    np.testing.assert_allclose(few.area, shape.area, rtol=0.1 if most > 500 else 0.3)
    assert n_parts(few) == 1
    assert few.weights.mean() > 0.6, "the largest of each cube"


def test_dense_places_do_not_hide_sparse_ones():
    """The search looks at a sample, the limit holds for all."""
    shape = joined([grid(300, size=0.01), grid(60, z=0.5, size=1.0)])
    few = result_of(simplified(shape, 400))
    assert 200 < len(few.points) <= 400


def test_both_sides_of_a_thin_wall_stay():
    front, back = grid(5), grid(5, z=1e-3)
    wall = clustered(joined([front, Shape(back.points, back.triangles[:, ::-1], back.weights)]), 0.1)
    assert (len(wall.points), len(wall.triangles)) == (25, 64)


def test_long_edges_are_split_and_the_surface_stays():
    shape = Shape(np.array([[0.0, 0, 0], [3, 0, 0], [0, 0.2, 0], [3, 1, 0]]), np.array([[0, 1, 2], [2, 1, 3]]),
                  np.array([[1, 1, 0.5, 0]], dtype=np.float32))  # fmt: skip
    fine = split_edges(shape, 0.3)
    assert longest(fine) <= 0.3
    np.testing.assert_array_equal(fine.points[:4], shape.points)
    np.testing.assert_allclose(fine.area, shape.area)
    a, b, c = (fine.points[corner] for corner in fine.triangles.T)
    assert (np.cross(b - a, c - a)[:, 2] > 0).all(), "windings stay"
    on_edge = np.flatnonzero(fine.points[:, 1] == 0)
    np.testing.assert_array_equal(fine.weights[0, on_edge], 1.0)
    assert n_parts(fine) == 1


def test_only_chosen_edges_are_split_and_without_gaps():
    shape = grid(4)
    fine = split_edges(shape, 0.05, lambda now: now.points[:, 0] > 0.9)
    assert longest(fine) > 0.3
    is_near = fine.points[fine.triangles][:, :, 0].max(axis=1) > 0.9
    assert longest(Shape(fine.points, fine.triangles[is_near], fine.weights)) <= 0.05
    sides = np.sort(
        np.concatenate([fine.triangles[:, [0, 1]], fine.triangles[:, [1, 2]], fine.triangles[:, [2, 0]]]), 1
    )
    _, counts = np.unique(sides, axis=0, return_counts=True)
    ends = np.unique(sides, axis=0)[counts == 1]
    on_border = (np.abs(fine.points[ends] - 0.5) > 0.4999).any(axis=2)
    assert counts.max() == 2
    assert on_border.all(), "a side with one triangle is on the border"


def test_near_parts_are_connected_and_far_ones_are_not():
    far = moved(grid(3), 0.0, 0.0, 0.7)
    crossing = Shape(grid(3).points[:, [2, 0, 1]] + (0.5, 0.1, -0.5), grid(3).triangles, grid(3).weights)
    shape = joined([grid(2), crossing, grid(2, z=0.004), far])
    whole = result_of(connected(shape, 200_000))
    np.testing.assert_array_equal(whole.points[: len(shape.points)], shape.points)
    np.testing.assert_allclose(whole.area, shape.area, rtol=1e-9)  # bridges have no area
    assert n_parts(shape) == 4
    assert n_parts(whole) == 2
    assert len(np.unique(parts_of(whole)[:17])) == 1
    # Along all of a line where two meet, not at one place.
    new = whole.points[-(len(whole.points) // 10) :]
    assert np.ptp(new[:, 1]) > 0.8


def reach_of_bridges(shape):
    """The largest x of what is between the two squares."""
    is_between = (shape.points[:, 2] > 0.005) & (shape.points[:, 2] < 0.015)
    return shape.points[is_between, 0].max()


def test_wider_gaps_are_bridged_only_between_parts_without_another_bridge():
    near = [grid(30), grid(30, z=0.02)]
    alone = result_of(connected(joined(near), 200_000))
    assert n_parts(alone) == 1
    assert reach_of_bridges(alone) > 0.9
    tied = joined([*near, Shape(grid(2).points[:, [2, 0, 1]] * (1, 1, 0.02), grid(2).triangles, grid(2).weights)])
    together = result_of(connected(tied, 200_000))
    assert n_parts(together) == 1
    assert reach_of_bridges(together) < 0.05, "only where the third one is"


def test_parts_that_are_near_but_do_not_meet_stay_free_if_others_hold_them():
    """Two fingers side by side, and the palm that both are stuck into."""
    gap = 0.01
    palm = moved(grid(2), -0.5, -0.5, 0.0)
    fingers = [moved(Shape(grid(2).points[:, [0, 2, 1]], *fields(grid(2))), -0.5, y, -0.1) for y in (0.0, gap)]
    hand = result_of(connected(joined([palm, *fingers]), 200_000))
    assert n_parts(hand) == 1
    is_between = (hand.points[:, 1] > 0.2 * gap) & (hand.points[:, 1] < 0.8 * gap)
    assert np.abs(hand.points[is_between, 2]).max() < 0.02, "only of the palm"
    touching = joined([palm, fingers[0], moved(fingers[1], 0.0, -0.9 * gap, 0.0)])
    hand = result_of(connected(touching, 200_000))
    is_between = (hand.points[:, 1] > 0.02 * gap) & (hand.points[:, 1] < 0.08 * gap)
    assert hand.points[is_between, 2].max() > 0.8, "these meet"


def test_few_vertices_stay_few():
    shape = joined([grid(2), grid(2, z=0.001)])
    assert len(result_of(connected(shape, 400)).points) < 2000


def test_much_area_in_many_layers_has_no_end_of_vertices():
    layers = joined([grid(2, z=0.002 * k) for k in range(40)])
    whole = result_of(connected(layers, 2000))
    assert n_parts(whole) == 1
    assert len(whole.points) < 20_000
