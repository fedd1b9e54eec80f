# SPDX-License-Identifier: GPL-3.0-or-later
"""Handles that are added one by one, as a script does: the hundredth costs what the second does."""

from unittest import mock

import numpy as np
from looks import rest_positions
from support import SceneTest, bpy, module
from tubes import PLACED, SEGMENTS, Matrix, empty_at, mesh_object

N = 60


class Counts:
    """What an add does that takes longer in a larger scene, or with more handles."""

    def __init__(self) -> None:
        self.n_evaluated = self.n_groups = self.n_sized = 0
        self._patches = [
            self._counting("scene.versions", "read_group_weights", "n_groups", lambda _obj, names, *_: len(names)),
            self._counting("setup.made_objects", "resize_empty", "n_sized", lambda *_: 1),
        ]

    def __enter__(self):
        bpy.app.handlers.depsgraph_update_post.append(self._evaluated)
        for patch in self._patches:
            patch.start()
        return self

    def __exit__(self, *_: object) -> None:
        bpy.app.handlers.depsgraph_update_post.remove(self._evaluated)
        for patch in self._patches:
            patch.stop()

    def of_next(self, act) -> tuple[int, int, int]:
        self.n_evaluated = self.n_groups = self.n_sized = 0
        act()
        return self.n_evaluated, self.n_groups, self.n_sized

    def _evaluated(self, *_: object) -> None:
        self.n_evaluated += 1

    def _counting(self, name, function, counter, count):
        original = getattr(module(name), function)

        def counted(*args, **kwargs):
            setattr(self, counter, getattr(self, counter) + count(*args))
            return original(*args, **kwargs)

        return mock.patch.object(module(name), function, counted)


class ManyHandlesTest(SceneTest):
    def test_each_costs_the_same(self):
        """Points, which look for others near them, and handles that hold their vertices."""
        for use_exact in (False, True):
            for matrix in (None, PLACED):
                with self.subTest(use_exact=use_exact, is_placed=matrix is not None):
                    self.setUp()
                    obj = mesh_object(matrix=matrix)
                    obj.parent = empty_at((1.0, 2.0, 3.0))
                    bpy.context.view_layer.update()

                    def add(vertex, obj=obj, use_exact=use_exact):
                        self.api.add_handle(obj, [vertex], name="Point", use_exact=use_exact)

                    with Counts() as counts:
                        costs = [counts.of_next(lambda vertex=vertex: add(vertex)) for vertex in range(N)]
                    self.assertEqual({(evaluated, sized) for evaluated, _, sized in costs}, {(0, 1)})
                    most_near = 4 * SEGMENTS
                    self.assertLess(max(groups for _, groups, _ in costs), most_near)
                    bpy.context.view_layer.update()
                    places = [handle.target.matrix_world.translation for handle in obj.arap.handles]
                    world = np.array(obj.matrix_world)
                    rest = rest_positions(obj)[:N] @ world[:3, :3].T + world[:3, 3]
                    self.assert_close(np.array(places), rest, 0.0 + (1e-5 if use_exact else 0.2))

    def test_where_the_object_is_now_counts(self):
        """Also if nothing has evaluated that: moved by a script, a parent, a constraint, a driver."""
        moves = {
            "itself": lambda obj, other: setattr(obj, "location", (0.0, 0.0, 5.0)),
            "its parent": lambda obj, other: (
                setattr(obj, "parent", other),
                setattr(other, "location", (0.0, 0.0, 5.0)),
            ),
            "a constraint": lambda obj, other: (
                setattr(obj.constraints.new("COPY_LOCATION"), "target", other),
                setattr(other, "location", (0.0, 0.0, 5.0)),
            ),
            "a driver": lambda obj, other: setattr(obj.driver_add("location", 2).driver, "expression", "5.0"),
        }
        for what, act in moves.items():
            with self.subTest(what):
                self.setUp()
                obj, other = mesh_object(), empty_at((0.0, 0.0, 0.0))
                self.api.add_handle(obj, [0], use_exact=True)
                act(obj, other)
                handle = obj.arap.controls[self.api.add_handle(obj, [0], use_exact=True)]
                bpy.context.view_layer.update()
                place = Matrix(obj.matrix_world) @ obj.data.vertices[0].co
                self.assertAlmostEqual(obj.matrix_world.translation.z, 5.0)
                self.assert_close(handle.target.matrix_world.translation, place, 1e-5)
