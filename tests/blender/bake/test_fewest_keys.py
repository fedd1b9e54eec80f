# SPDX-License-Identifier: GPL-3.0-or-later
"""Fewest keys: the blend that Blender shows is within the tolerance of the true frame, at every frame."""

import numpy as np
from looks import data_of, in_world, key_positions, rest_positions, shown_positions
from support import SceneTest, bpy, module
from tubes import PLACED, animated


class FewestKeysTest(SceneTest):
    def largest_error(self, obj, true_names) -> float:
        """Of all frames, in world units, between what is shown and the keys of a whole bake."""
        truth = [key_positions(obj, name) for name in true_names]
        for name in true_names:
            obj.data.shape_keys.key_blocks[name].mute = True
        errors = []
        for frame, positions in enumerate(truth, 1):
            self.scene.frame_set(frame)
            off = in_world(obj, shown_positions(obj)) - in_world(obj, positions)
            errors.append(np.linalg.norm(off, axis=1).max())
        return max(errors)

    def test_every_frame_is_within_the_tolerance_as_seen(self):
        for matrix, percent, fewest_than in ((None, 1.0, 12), (PLACED, 1.5, 14)):
            with self.subTest(is_stretched=matrix is not None):
                self.setUp()
                obj = animated(matrix)
                stretch = module("scene.meshes").read_stretch(obj, bpy.context.evaluated_depsgraph_get())
                size = np.linalg.norm(np.ptp(rest_positions(obj) @ stretch.T, axis=0))
                true_names = self.api.bake_animation(obj, 1, 21, prefix="True ")
                job = module("bake.keys").BakeJob(obj, 1, 21, fewest_keys_percent=percent)
                names = module("core.job").run_job(job)
                error = self.largest_error(obj, true_names)
                self.assertLessEqual(error, percent / 100.0 * size + 2e-6)
                self.assertLess(len(names), fewest_than)
                self.assertEqual((names[0], names[-1]), ("ARAP_0001", "ARAP_0021"))
                self.assertEqual((job.fit.n_frames, job.fit.n_keys), (21, len(names)))
                self.assertAlmostEqual(job.fit.size, size, delta=1e-5)
                self.assertAlmostEqual(job.fit.largest_distance, error, delta=5e-6)

    def test_only_solved_frames_become_keys(self):
        names = self.api.bake_animation(animated(), 1, 20, 3, fewest_keys_percent=5.0)
        self.assertEqual((names[0], names[-1]), ("ARAP_0001", "ARAP_0020"))
        self.assertTrue({int(name[-4:]) for name in names} <= {1, 4, 7, 10, 13, 16, 19, 20})

    def test_the_search_goes_in_steps_and_can_be_cancelled(self):
        obj = animated()
        before = data_of(obj)
        job = module("bake.keys").BakeJob(obj, 1, 21, fewest_keys_percent=1.0)
        while job.fraction < 1.0:
            self.assertTrue(job.step())
        message = "The bake of 'Tube' is not done: call step() until it returns False"
        self.assert_error(RuntimeError, message, job.finish)
        n_steps = 0
        while job.step(time_limit_s=0.0):
            self.assertEqual(job.status, "all frames are solved, searching the fewest keys")
            n_steps += 1
        self.assertGreater(n_steps, 20)
        job.cancel()
        self.assertEqual(data_of(obj), before)

    def test_the_operator_says_how_many(self):
        obj = animated()
        bpy.context.view_layer.objects.active = obj
        done = bpy.ops.arap.bake_animation(frame_start=1, frame_end=21, use_fewest_keys=True, fewest_keys_percent=2.0)
        self.assertEqual(done, {"FINISHED"})
        self.assertLess(len(obj.data.shape_keys.key_blocks), 14)
