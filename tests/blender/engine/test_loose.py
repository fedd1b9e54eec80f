# SPDX-License-Identifier: GPL-3.0-or-later
"""Loose pieces go along: a tube is a head with an eye in its mesh, and a ball is far from it."""

import numpy as np
from looks import edge_lengths, key_positions, rest_positions, shown_positions
from support import SceneTest, bpy, module, opened_again
from tubes import BALL, LENGTH, PLACED, RINGS, SEGMENTS, animate, bend, with_balls

EYE = slice(RINGS * SEGMENTS, RINGS * SEGMENTS + BALL)
FAR = slice(EYE.stop, EYE.stop + BALL)
PLACES = (0.5, 0.0, 0.8 * LENGTH), (4.0, 0.0, 0.0)


class LooseTest(SceneTest):
    def assert_follows(self, obj, positions):
        """The eye has moved and kept its shape, and the ball has stayed."""
        rest = rest_positions(obj)
        self.assertGreater(np.abs(positions[EYE] - rest[EYE]).max(), 0.3)
        of_eye = np.array([edge.vertices[0] in range(EYE.start, EYE.stop) for edge in obj.data.edges])
        self.assert_close(edge_lengths(obj, positions)[of_eye], edge_lengths(obj, rest)[of_eye], 3e-6)
        self.assert_close(positions[FAR], rest[FAR], 4e-6)
        # It still stands out of the surface as at rest.
        middle = positions[EYE].mean(axis=0)
        self.assertLess(np.linalg.norm(positions[: EYE.start] - middle, axis=1).min(), 0.35)

    def test_an_eye_follows_through_undo_a_saved_file_and_a_bake(self):
        obj = with_balls(*PLACES)
        obj.arap.use_follow = True
        bpy.context.view_layer.update()
        bpy.ops.ed.undo_push(message="at rest")
        bend(obj)
        bent = shown_positions(obj)
        self.assert_follows(obj, bent)
        bpy.ops.ed.undo_push(message="bent")
        bpy.ops.ed.undo()
        obj = bpy.data.objects["Tube"]
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), rest_positions(obj), 4e-6)
        bpy.ops.ed.redo()
        obj = opened_again()
        self.assertTrue(obj.arap.use_loose_parts)
        self.assert_close(shown_positions(obj), bent, 1e-6)
        animate(obj)
        names = self.api.bake_animation(obj, 1, 21, 10)
        self.assert_follows(obj, key_positions(obj, names[1]))

    def test_the_switch_is_saved_and_counts_at_once(self):
        obj = with_balls(*PLACES, matrix=PLACED)
        bend(obj)
        self.assertEqual(self.api.solve(obj).parts_at_rest, 1)
        self.assert_follows(obj, key_positions(obj))
        obj.arap.use_loose_parts = False
        obj = opened_again()
        self.assertFalse(obj.arap.use_loose_parts)
        self.assertEqual(self.api.solve(obj).parts_at_rest, 2)
        self.assert_close(key_positions(obj)[EYE], rest_positions(obj)[EYE], 4e-6)

    def test_what_follows_is_no_free_part(self):
        obj = with_balls(*PLACES)
        for follows, expected in ((True, FAR), (False, slice(EYE.start, FAR.stop))):
            obj.arap.use_loose_parts = follows
            vertices, n_parts = module("setup.free_parts").find(obj, bpy.context.evaluated_depsgraph_get())
            np.testing.assert_array_equal(vertices, np.arange(expected.start, expected.stop))
            self.assertEqual(n_parts, self.api.solve(obj).parts_at_rest)

    def test_apply_pose_as_rest_takes_the_eye_along(self):
        obj = with_balls(*PLACES)
        bend(obj)
        self.api.solve(obj)
        bent = key_positions(obj)
        self.api.apply_pose_as_rest(obj)
        self.assert_close(rest_positions(obj), bent, 1e-6)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), bent, 1e-5)
