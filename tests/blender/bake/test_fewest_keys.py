# SPDX-License-Identifier: GPL-3.0-or-later
"""Fewest keys: the blend that Blender shows is near the true frame, at every frame."""

import numpy as np
from support import (
    PLACED,
    SceneTest,
    animate,
    bpy,
    data_of,
    in_world,
    key_positions,
    module,
    posable,
    rest_positions,
    shown_positions,
)


def size_of(obj) -> float:
    """The diagonal of the box at rest, as seen."""
    stretch = module("scene.meshes").read_stretch(obj, bpy.context.evaluated_depsgraph_get())
    return float(np.linalg.norm(np.ptp(rest_positions(obj) @ stretch.T, axis=0)))


def largest_distances(obj, scene, true_names, frames) -> list[float]:
    """For each frame, in world units, between what is shown and the key of that frame of a whole bake."""
    truth = {frame: key_positions(obj, name) for frame, name in zip(frames, true_names, strict=True)}
    for name in true_names:
        obj.data.shape_keys.key_blocks[name].mute = True
    result = []
    for frame in frames:
        scene.frame_set(frame)
        off = in_world(obj, shown_positions(obj)) - in_world(obj, truth[frame])
        result.append(float(np.linalg.norm(off, axis=1).max()))
    return result


class FewestKeysTest(SceneTest):
    def check_within(self, obj, percent, fewest_than):
        true_names = self.api.bake_animation(obj, 1, 21, prefix="True ")
        job = module("bake.keys").begin_bake(obj, 1, 21, fewest_keys_percent=percent)
        names = module("core.job").run_job(job)
        off = max(largest_distances(obj, self.scene, true_names, range(1, 22)))
        self.assertLessEqual(off, percent / 100.0 * size_of(obj) + 2e-6)
        self.assertLess(len(names), fewest_than)
        self.assertEqual(names[0], "ARAP_0001")
        self.assertEqual(names[-1], "ARAP_0021")
        self.assertEqual((job.fit.n_frames, job.fit.n_keys), (21, len(names)))
        self.assertAlmostEqual(job.fit.size, size_of(obj), delta=1e-5)
        self.assertAlmostEqual(job.fit.largest_distance, off, delta=5e-6)
        return job, names

    def test_every_frame_is_within_the_tolerance(self):
        obj = posable()
        animate(obj)
        job, names = self.check_within(obj, 1.0, 12)
        percent = 100.0 * job.fit.largest_distance / job.fit.size
        expected = f"{len(names)} keys for 21 frames, off by {percent:.3f} % of the size at most"
        self.assertEqual(str(job.fit), expected)
        self.assertEqual(str(module("bake.keys").Fit(21, 21, 0.0, 1.0)), "21 keys")

    def test_it_is_measured_as_seen_on_a_stretched_object(self):
        obj = posable(matrix=PLACED)
        animate(obj)
        self.check_within(obj, 1.5, 14)

    def test_steps_and_one_frame(self):
        obj = posable()
        animate(obj)
        names = self.api.bake_animation(obj, 1, 20, 3, fewest_keys_percent=5.0)
        self.assertEqual((names[0], names[-1]), ("ARAP_0001", "ARAP_0020"))
        self.assertTrue({int(name[-4:]) for name in names} <= {1, 4, 7, 10, 13, 16, 19, 20})
        self.assertEqual(self.api.bake_animation(obj, 5, 5, fewest_keys_percent=5.0), ["ARAP_0005"])

    def test_the_search_goes_in_steps_and_can_be_cancelled(self):
        obj = posable()
        animate(obj)
        before = data_of(obj)
        job = module("bake.keys").begin_bake(obj, 1, 21, fewest_keys_percent=1.0)
        while job.fraction < 1.0:
            self.assertTrue(job.step())
        message = "The bake of 'Tube' is not done: call step() until it returns False"
        self.assert_error(RuntimeError, message, job.finish)
        n_steps = 0
        while job.step(time_limit_s=0.0):
            self.assertEqual(job.status, "all frames are solved, choosing the fewest keys")
            n_steps += 1
        self.assertGreater(n_steps, 20)
        job.cancel()
        self.assertEqual(data_of(obj), before)

    def test_a_wrong_tolerance_is_refused(self):
        obj = posable()
        for percent in (-1.0, 101.0, float("nan")):
            message = f"fewest_keys_percent = {percent}, must be between 0 and 100"
            self.assert_error(
                ValueError, message, module("bake.keys").begin_bake, obj, 1, 5, fewest_keys_percent=percent
            )

    def test_the_operator_says_how_many(self):
        obj = posable()
        animate(obj)
        bpy.context.view_layer.objects.active = obj
        done = bpy.ops.arap.bake_animation(frame_start=1, frame_end=21, use_fewest_keys=True, fewest_keys_percent=2.0)
        self.assertEqual(done, {"FINISHED"})
        self.assertLess(len(obj.data.shape_keys.key_blocks), 14)
