# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake over a former one, and the walk over the frames."""

import numpy as np
from looks import key_names, key_positions
from support import SceneTest, module
from tubes import animated, mesh_object, own_key


class FormerBakeTest(SceneTest):
    """Keys of former bakes are evaluated for nothing while a new one reads the frames."""

    def values(self, obj, names):
        return [obj.data.shape_keys.key_blocks[name].value for name in names]

    def mutes(self, *objs):
        """Of all F-curves and drivers."""
        keys = [obj.data.shape_keys for obj in objs]
        curves = [c for k in keys for c in (*module("scene.fcurves").all_fcurves_of(k), *k.animation_data.drivers)]
        return [curve.mute for curve in curves]

    def test_they_do_not_change_while_another_bake_reads_the_frames(self):
        obj = animated()
        shirt = mesh_object("Shirt")
        self.api.attach(obj, [shirt])
        names = [*self.api.bake_animation(obj, 1, 4, prefix="One "), *self.api.bake_animation(obj, 1, 4)]
        smile = own_key(obj, "Smile", value=0.0)
        smile.keyframe_insert("value", frame=1)
        self.scene.frame_set(1)
        before, mutes = (self.values(obj, names), self.values(shirt, names)), self.mutes(obj, shirt)
        self.assertFalse(any(mutes))
        for is_cancelled in (True, False):
            job = module("bake.keys").BakeJob(obj, 1, 4)
            frames = []
            while job.fraction == 0.0 or job.frame < 3:
                job.step(1e-6)
                frames.append(self.scene.frame_current)
                self.assertEqual((self.values(obj, names), self.values(shirt, names)), before)
            self.assertEqual(set(frames), {1, 2, 3}, "with the last frame it goes back")
            self.assertEqual(self.mutes(obj, shirt), mutes, "all frames are read")
            if is_cancelled:
                job.cancel()
                self.assertEqual(self.mutes(obj, shirt), mutes)
        while job.step():
            pass
        job.finish()
        self.assertFalse(any(self.mutes(obj, shirt)))

    def test_a_cancel_while_frames_are_read_wakes_them_and_only_them(self):
        obj = animated()
        names = self.api.bake_animation(obj, 1, 4)
        curves = module("scene.fcurves").fcurves_of(obj.data.shape_keys)
        curves[1].mute = True
        before = self.mutes(obj)
        job = module("bake.keys").BakeJob(obj, 1, 4)
        job.step(1e-6)
        self.assertTrue(all(self.mutes(obj)))
        job.cancel()
        self.assertEqual(self.mutes(obj), before)
        self.assertEqual(key_names(obj), ["Basis", *names])

    def test_an_export_too(self):
        obj = animated()
        names = self.api.bake_animation(obj, 1, 4)
        self.scene.frame_set(1)
        before = self.values(obj, names)
        job = module("bake.cache").MeshCacheJob(obj, self.new_folder() / "tube.mdd", 1, 4)
        job.step(1e-6)
        job.step(1e-6)
        self.assertEqual((self.scene.frame_current, self.values(obj, names)), (2, before))
        job.cancel()

    def test_their_keys_are_written_again_and_none_gets_another_name(self):
        """For a new name Blender searches all animation of the file."""
        obj = animated()
        names = self.api.bake_animation(obj, 1, 4)
        keys = obj.data.shape_keys.key_blocks
        addresses = {name: keys[name].as_pointer() for name in names}
        changed = keys["ARAP_0002"]
        changed.mute, changed.slider_max, changed.vertex_group = True, 5.0, "Head"
        shapes = [key_positions(obj, name) for name in names]
        obj.arap.handles[0].target.animation_data.action = None
        obj.arap.handles[0].target.location.x += 1.0
        self.assertEqual(self.api.bake_animation(obj, 2, 5), ["ARAP_0002", "ARAP_0003", "ARAP_0004", "ARAP_0005"])
        self.assertEqual({n: keys[n].as_pointer() for n in names[1:]}, {n: addresses[n] for n in names[1:]})
        self.assertNotIn("ARAP_0001", keys)
        self.assertEqual((changed.mute, changed.slider_max, changed.vertex_group), (False, 1.0, ""))
        self.assertGreater(np.abs(key_positions(obj, "ARAP_0002") - shapes[1]).max(), 0.5)

    def test_frames_are_read_before_any_is_solved(self):
        """A handle that breaks in the last frame is told before the work; and the scene is where it was meanwhile."""
        obj = animated()
        target = obj.arap.handles[0].target
        for target.hide_viewport, frame in ((False, 1), (True, 9)):
            target.keyframe_insert("hide_viewport", frame=frame)
        self.scene.frame_set(2)
        job = module("bake.keys").BakeJob(obj, 1, 9)
        with self.assertRaisesRegex(ValueError, "'Head' is disabled in viewports"):
            while job.step():
                self.assertEqual(job.fraction, 0.0)
        job.cancel()
        self.assertEqual(self.scene.frame_current, 2)
