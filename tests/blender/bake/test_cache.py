# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh caches, read by Blender's own Mesh Cache modifier."""

import tempfile
from pathlib import Path

import numpy as np
from support import PLACED, SceneTest, animate, bpy, data_of, key_positions, module, posable, shown_positions


class MeshCacheTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name).resolve()

    def animated(self, matrix=None):
        obj = posable(matrix=matrix)
        animate(obj)
        return obj

    def check_frames(self, obj, shapes, frames):
        """What the modifier shows at each frame is the pose of that frame."""
        for shape, frame in zip(shapes, frames, strict=True):
            self.scene.frame_set(frame)
            self.assert_close(shown_positions(obj), shape, 2e-6)

    def baked_shapes(self, obj, *frames):
        """The truth, by a bake whose keys are taken away again."""
        names = self.api.bake_animation(obj, *frames)
        shapes = [key_positions(obj, name) for name in names]
        obj.shape_key_clear()
        return shapes

    def test_the_modifier_shows_the_frames(self):
        for end in (".mdd", ".pc2"):
            for matrix in (None, PLACED):
                with self.subTest(end=end, is_placed=matrix is not None):
                    self.setUp()
                    obj = self.animated(matrix)
                    shapes = self.baked_shapes(obj, 3, 13)
                    self.scene.frame_set(2)
                    path = self.folder / f"tube{end}"
                    self.assertEqual(self.api.export_mesh_cache(obj, path, 3, 13, add_modifier=True), path)
                    self.assertEqual(self.scene.frame_current, 2)
                    self.assertIsNone(obj.data.shape_keys)
                    self.check_frames(obj, shapes, range(3, 14))
                    self.check_frames(obj, [shapes[0], shapes[-1]], [-20, 40])  # beyond its ends it holds
                    self.assertGreater(np.abs(shapes[5] - shapes[0]).max(), 0.5)

    def test_steps_and_in_between(self):
        obj = self.animated()
        shapes = self.baked_shapes(obj, 2, 17, 5)
        for end in (".mdd", ".pc2"):
            self.api.export_mesh_cache(obj, self.folder / f"tube{end}", 2, 18, 5, add_modifier=True)
            self.check_frames(obj, shapes, (2, 7, 12, 17))
            self.scene.frame_set(9)
            self.assert_close(shown_positions(obj), 0.6 * shapes[1] + 0.4 * shapes[2], 2e-6)
        self.assertEqual(len(obj.modifiers), 1)

    def test_the_modifier_comes_first_and_once(self):
        obj = self.animated()
        obj.modifiers.new("Subdivision", "SUBSURF")
        obj.modifiers.new("Bend", "SIMPLE_DEFORM")
        for _ in range(2):
            self.api.export_mesh_cache(obj, self.folder / "tube.mdd", 1, 5, add_modifier=True)
            self.assertEqual([modifier.name for modifier in obj.modifiers], ["ARAP Cache", "Subdivision", "Bend"])

    def test_a_modifier_by_chance_of_that_name_stays(self):
        obj = self.animated()
        obj.modifiers.new("ARAP Cache", "SUBSURF")
        self.api.export_mesh_cache(obj, self.folder / "tube.mdd", 1, 3, add_modifier=True)
        self.assertEqual([modifier.type for modifier in obj.modifiers], ["MESH_CACHE", "SUBSURF"])

    def test_without_the_modifier_the_scene_stays(self):
        obj = self.animated()
        obj.shape_key_add(name="Basis")
        before = data_of(obj)
        self.api.export_mesh_cache(obj, self.folder / "tube.mdd", 1, 5)
        self.assertEqual(len(obj.modifiers), 0)
        self.assertEqual(data_of(obj), before)

    def test_the_header_has_the_scenes_rate(self):
        obj = self.animated()
        self.scene.render.fps, self.scene.render.fps_base = 30, 1.001
        self.api.export_mesh_cache(obj, self.folder / "tube.mdd", 5, 8)
        data = (self.folder / "tube.mdd").read_bytes()
        self.assertEqual(np.frombuffer(data[:8], ">i4").tolist(), [4, len(obj.data.vertices)])
        self.assert_close(np.frombuffer(data[8:24], ">f4"), np.arange(4) * 1.001 / 30, 1e-7)
        self.api.export_mesh_cache(obj, self.folder / "tube.pc2", 5, 8)
        head = (self.folder / "tube.pc2").read_bytes()[20:28]
        self.assertEqual(np.frombuffer(head, "<f4").tolist(), [5.0, 1.0])

    def test_posing_under_a_cache_is_refused(self):
        obj = self.animated()
        self.api.solve(obj)
        self.api.export_mesh_cache(obj, self.folder / "tube.mdd", 1, 5, add_modifier=True)
        message = "Modifier 'ARAP Cache' of 'Tube' shows a cache in place of the pose: switch it off in viewports"
        self.assert_error(ValueError, message, self.api.solve, obj)
        self.assert_error(ValueError, message, self.api.bake_pose, obj)
        obj.modifiers["ARAP Cache"].show_viewport = False
        self.api.solve(obj)
        self.api.export_mesh_cache(obj, self.folder / "tube.mdd", 1, 5, add_modifier=True)

    def test_paths(self):
        obj = self.animated()
        self.assert_error(
            ValueError,
            "tube.abc is neither .mdd nor .pc2: give the cache one of these ends",
            self.api.export_mesh_cache, obj, self.folder / "tube.abc", 1, 5,
        )  # fmt: skip
        path = self.folder / "nowhere" / "tube.mdd"
        message = f"{path} cannot be written (No such file or directory): choose another folder or another name"
        self.assert_error(ValueError, message, self.api.export_mesh_cache, obj, path, 1, 5)
        self.assertEqual(module("core.sessions").claimed_by("Tube"), "")
        self.assert_error(
            ValueError, "The last frame 1 is before the first, 5: swap them",
            self.api.export_mesh_cache, obj, self.folder / "tube.mdd", 5, 1,
        )  # fmt: skip
        bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / "scene.blend"))
        obj = bpy.data.objects["Tube"]
        self.api.export_mesh_cache(obj, "//tube.mdd", 1, 5, add_modifier=True)
        self.assertEqual(obj.modifiers[0].filepath, "//tube.mdd")
        self.assertTrue((self.folder / "tube.mdd").is_file())
        bpy.context.preferences.filepaths.use_relative_paths = False
        self.addCleanup(setattr, bpy.context.preferences.filepaths, "use_relative_paths", True)
        self.api.export_mesh_cache(obj, "//tube.mdd", 1, 5, add_modifier=True)
        self.assertEqual(obj.modifiers[0].filepath, str(self.folder / "tube.mdd"))

    def test_a_cancelled_export_leaves_nothing(self):
        obj = self.animated()
        path = self.folder / "tube.mdd"
        path.write_text("older")
        before = data_of(obj)
        message = "The export of 'Tube' was cancelled; nothing has changed"
        self.assert_error(
            self.api.Cancelled, message, self.api.export_mesh_cache, obj, path, 1, 21, 1, lambda done: done < 0.5
        )
        self.assertEqual(data_of(obj), before)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["tube.mdd"])
        self.assertEqual(path.read_text(), "older")
        self.assertEqual(len(obj.modifiers), 0)

    def test_the_operator(self):
        obj = self.animated()
        bpy.context.view_layer.objects.active = obj
        path = self.folder / "tube.pc2"
        done = bpy.ops.arap.export_mesh_cache(filepath=str(path), cache_format="PC2", frame_start=1, frame_end=4)
        self.assertEqual(done, {"FINISHED"})
        self.assertEqual(obj.modifiers[0].cache_format, "PC2")
        n = len(obj.data.vertices)
        self.assertEqual(path.stat().st_size, 32 + 4 * n * 12)

    def test_other_shape_keys_are_not_in_it(self):
        obj = self.animated()
        shapes = self.baked_shapes(obj, 1, 3)
        obj.shape_key_add(name="Basis")
        smile = obj.shape_key_add(name="Smile")
        for point in smile.data:
            point.co.x += 1.0
        smile.value = 1.0
        self.api.export_mesh_cache(obj, self.folder / "tube.mdd", 1, 3, add_modifier=True)
        self.check_frames(obj, shapes, (1, 2, 3))
