# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes and caches in a scene with Time Stretching."""

from looks import key_positions, shown_positions
from support import SceneTest, module
from tubes import animated


class TimeStretchingTest(SceneTest):
    """Blender evaluates F-curves and caches at another time than the number of the frame. A frame shows its pose."""

    def stretch(self, old, new):
        self.scene.render.frame_map_old, self.scene.render.frame_map_new = old, new

    def assert_frames(self, obj, shapes, frames):
        for frame, shape in zip(frames, shapes, strict=True):
            self.scene.frame_set(frame)
            self.assert_close(shown_positions(obj), shape, 1e-4)

    def solved_shapes(self, obj, frames):
        shapes = []
        for frame in frames:
            self.scene.frame_set(frame)
            self.api.solve(obj)
            shapes.append(key_positions(obj))
        return shapes

    def test_keys(self):
        for old, new in ((100, 50), (100, 200), (100, 300)):
            for percent in (None, 0.001):
                with self.subTest(new=new, fewest_keys=percent):
                    self.setUp()
                    obj = animated()
                    self.stretch(old, new)
                    obj.arap.accuracy, obj.arap.max_iterations = 1e-7, 5000
                    frames = range(3, 24, 5)
                    solved = self.solved_shapes(obj, frames)
                    names = self.api.bake_animation(obj, 3, 23, 5, fewest_keys_percent=percent)
                    self.assert_frames(obj, solved, frames)
                    self.assertEqual((names[0], names[-1]), ("ARAP_0003", "ARAP_0023"), "as the frames are numbered")

    def test_a_cache(self):
        for suffix in (".mdd", ".pc2"):
            for new, step in ((50, 1), (200, 1), (300, 5)):
                with self.subTest(suffix=suffix, new=new):
                    self.setUp()
                    obj, path = animated(), self.new_folder() / f"tube{suffix}"
                    self.stretch(100, new)
                    obj.arap.accuracy, obj.arap.max_iterations = 1e-7, 5000
                    frames = range(3, 24, 5)
                    solved = self.solved_shapes(obj, frames)
                    self.api.export_mesh_cache(obj, path, 3, 23, step, add_modifier=True)
                    self.assert_frames(obj, solved, frames)

    def test_a_stretch_that_the_modifier_cannot_play_is_refused_before_the_first_frame(self):
        obj, path = animated(), self.new_folder() / "tube.mdd"
        self.stretch(1, 101)
        message = (
            "Time Stretching of scene 'Scene' is more than a Mesh Cache modifier can play: New may be up to 100 times "
            "Old, or export without the modifier"
        )
        self.assert_error(ValueError, message, self.api.export_mesh_cache, obj, path, 1, 3, add_modifier=True)
        self.api.export_mesh_cache(obj, path, 1, 3)

    def test_the_proposed_frames_show_all_keyframes_of_the_handles(self):
        obj = animated()  # from 1 to 21
        for new, expected in ((100, (1, 21)), (50, (0, 11)), (200, (2, 42)), (300, (3, 63))):
            self.stretch(100, new)
            self.assertEqual(module("bake.frame_range").proposed_range(obj, self.scene), expected)
