# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface and Solid: the same handles, pins and pose with both, in every way to pose."""

import numpy as np
from looks import key_positions, rest_positions, shown_positions
from support import SceneTest, bpy, module, opened_again
from tubes import BOTTOM, MIDDLE, TOP, animated, move, posable


def handled(obj):
    """The places of the top by the handle."""
    motion = module("scene.handle_motion").handle_matrices(obj)[1]
    return rest_positions(obj)[TOP] @ motion[:3, :3].T + motion[:3, 3]


def girth(positions: np.ndarray) -> float:
    """Of the ring in the middle."""
    ring = positions[MIDDLE]
    return float(np.linalg.norm(ring - ring.mean(axis=0), axis=1).mean())


class ModelTest(SceneTest):
    def solid(self):
        obj = posable()
        obj.arap.model = "solid"
        return obj

    def assert_held(self, obj, positions):
        self.assertTrue(np.isfinite(positions).all())
        self.assert_close(positions[TOP], handled(obj), 1e-5)
        self.assert_close(positions[BOTTOM], rest_positions(obj)[BOTTOM], 1e-5)

    def test_settings_have_their_defaults_and_survive_a_save(self):
        obj = posable()
        settings = module("scene.snapshot").settings_of
        of_obj = settings(obj)
        self.assertEqual((of_obj.model, of_obj.cube_size, of_obj.keep_volume), ("surface", 0.0, 0.0))
        numbers = {item.identifier: item.value for item in obj.arap.bl_rna.properties["model"].enum_items}
        self.assertEqual(numbers, {"surface": 0, "solid": 1}, "files have the numbers")
        obj.arap.model, obj.arap.cube_size, obj.arap.keep_volume = "solid", 3.5, 0.5
        obj = opened_again()
        self.assertEqual((obj.arap.model, obj.arap.cube_size, obj.arap.keep_volume), ("solid", 3.5, 0.5))
        obj.arap.cube_size = 0.001
        self.assertAlmostEqual(settings(obj).cube_size, 1e-3, msg="the least that the solver takes")

    def test_a_change_of_the_model_keeps_handles_and_pose(self):
        obj = posable()
        move(obj.arap.handles[0].target, turn=(0.0, 0.0, 2.5))
        self.api.solve(obj)
        surface, handles = key_positions(obj), [handle.name for handle in obj.arap.handles]
        obj.arap.model = "solid"
        bpy.context.view_layer.update()
        self.assert_close(key_positions(obj), surface, 0.0)
        self.assertEqual([handle.name for handle in obj.arap.handles], handles)
        self.api.solve(obj)
        self.assert_held(obj, key_positions(obj))
        self.assertGreater(girth(key_positions(obj)), girth(surface) + 0.02)
        obj.arap.model = "surface"
        self.api.solve(obj)
        self.assert_close(key_positions(obj), surface, 5e-3)

    def test_follow_and_stored_poses(self):
        obj = self.solid()
        obj.arap.use_follow = True
        bpy.context.view_layer.update()
        move(obj.arap.handles[0].target, (0.5, 0.0, 0.3), (0.4, 0.0, 0.0))
        bpy.context.view_layer.update()
        self.assertEqual((obj.arap.use_follow, obj.arap.follow_error), (True, ""))
        self.assert_held(obj, shown_positions(obj))
        obj.arap.model = "surface"
        bpy.context.view_layer.update()
        self.assertEqual((obj.arap.use_follow, obj.arap.follow_error), (True, ""))
        self.assert_held(obj, shown_positions(obj))

    def test_a_bake_shows_the_place_of_the_handle_in_every_frame(self):
        obj = animated()
        obj.arap.model = "solid"
        for name, frame in zip(self.api.bake_animation(obj, 1, 21, 10), (1, 11, 21), strict=True):
            self.scene.frame_set(frame)
            self.assert_held(obj, key_positions(obj, name))

    def test_one_vertex_as_a_handle_pulls_a_hill(self):
        obj = self.solid()
        vertex = MIDDLE[0]
        self.api.add_handle(obj, [vertex], name="Point")
        out = 0.4 * rest_positions(obj)[vertex] * (1.0, 1.0, 0.0) / 0.5
        move(obj.arap.handles[1].target, out)
        self.api.solve(obj)
        moved = np.linalg.norm(key_positions(obj) - rest_positions(obj), axis=1)
        self.assertAlmostEqual(moved[vertex], 0.4, delta=1e-4)
        self.assertGreater(np.sort(moved)[-5], 0.05, "its neighbours come along")

    def test_cubes_too_small_for_the_mesh_are_refused_and_the_pose_stays(self):
        obj = self.solid()
        move(obj.arap.handles[0].target, (0.5, 0.0, 0.0))
        self.api.solve(obj)
        posed = key_positions(obj)
        obj.arap.cube_size = 0.1
        with self.assertRaisesRegex(ValueError, "smaller cubes would be too many"):
            self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 0.0)
