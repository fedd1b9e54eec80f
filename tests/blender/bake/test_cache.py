# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh caches, read by Blender's own Mesh Cache modifier. The bytes of a file are tested without Blender."""

import numpy as np
from looks import data_of, key_positions, shown_positions
from support import SceneTest, bpy, module, uid
from tubes import PLACED, animated, mesh_object, own_key


class MeshCacheTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.folder = self.new_folder()
        self.mdd = self.folder / "tube.mdd"

    def check_frames(self, obj, shapes, frames):
        """The modifier shows the pose of each frame."""
        for shape, frame in zip(shapes, frames, strict=True):
            self.scene.frame_set(frame)
            self.assert_close(shown_positions(obj), shape, 2e-6)

    def baked_shapes(self, obj, *frames):
        """The truth, by a bake whose keys are removed again."""
        shapes = [key_positions(obj, name) for name in self.api.bake_animation(obj, *frames)]
        obj.shape_key_clear()
        return shapes

    def test_the_modifier_shows_the_frames(self):
        for suffix in (".mdd", ".pc2"):
            for matrix in (None, PLACED):
                with self.subTest(suffix=suffix, is_placed=matrix is not None):
                    self.setUp()
                    obj = animated(matrix)
                    shapes = self.baked_shapes(obj, 3, 13)
                    self.scene.frame_set(2)
                    path = self.folder / f"tube{suffix}"
                    self.assertEqual(self.api.export_mesh_cache(obj, path, 3, 13, add_modifier=True), path)
                    self.assertEqual(self.scene.frame_current, 2)
                    self.assertIsNone(obj.data.shape_keys)
                    self.check_frames(obj, shapes, range(3, 14))
                    self.check_frames(obj, [shapes[0], shapes[-1]], [-20, 40])  # beyond its ends it holds
                    self.assertGreater(np.abs(shapes[5] - shapes[0]).max(), 0.5)

    def test_steps_and_in_between(self):
        obj = animated()
        shapes = self.baked_shapes(obj, 2, 17, 5)
        for suffix in (".mdd", ".pc2"):
            self.api.export_mesh_cache(obj, self.folder / f"tube{suffix}", 2, 18, 5, add_modifier=True)
            self.check_frames(obj, shapes, (2, 7, 12, 17))
            self.check_frames(obj, [0.6 * shapes[1] + 0.4 * shapes[2]], [9])
        self.assertEqual(len(obj.modifiers), 1)

    def test_the_modifier_comes_first_and_once(self):
        """A modifier that has its name by chance stays."""
        obj = animated()
        obj.modifiers.new("ARAP Cache", "SUBSURF")
        obj.modifiers.new("Bend", "SIMPLE_DEFORM")
        for _ in range(2):
            self.api.export_mesh_cache(obj, self.mdd, 1, 3, add_modifier=True)
            types = [modifier.type for modifier in obj.modifiers]
            self.assertEqual(types, ["MESH_CACHE", "SUBSURF", "SIMPLE_DEFORM"])
            obj.modifiers[1].name, obj.modifiers[0].name = "Subdivision", "ARAP Cache"

    def test_without_the_modifier_the_scene_stays(self):
        obj = animated()
        obj.shape_key_add(name="Basis")
        before = data_of(obj)
        self.api.export_mesh_cache(obj, self.mdd, 1, 5)
        self.assertEqual(len(obj.modifiers), 0)
        self.assertEqual(data_of(obj), before)

    def test_the_header_has_the_scenes_rate(self):
        self.scene.render.fps, self.scene.render.fps_base = 30, 1.001
        self.api.export_mesh_cache(animated(), self.mdd, 5, 8)
        self.assert_close(np.frombuffer(self.mdd.read_bytes()[8:24], ">f4"), np.arange(4) * 1.001 / 30, 1e-7)

    def test_posing_under_a_cache_is_refused(self):
        obj = animated()
        self.api.solve(obj)
        self.api.export_mesh_cache(obj, self.mdd, 1, 5, add_modifier=True)
        reason = "shows a cache in place of the pose: switch it off, in viewports and renders"
        message = f"Modifier 'ARAP Cache' of 'Tube' {reason}"
        for act in (self.api.solve, self.api.bake_pose):
            self.assert_error(ValueError, message, act, obj)
        obj.modifiers["ARAP Cache"].show_viewport = False
        self.assert_error(ValueError, message, self.api.solve, obj)  # in the final render it still shows
        obj.modifiers["ARAP Cache"].show_render = False
        self.api.solve(obj)
        self.api.export_mesh_cache(obj, self.mdd, 1, 5, add_modifier=True)

    def test_paths(self):
        obj = animated()
        path = self.folder / "nowhere" / "tube.mdd"
        for message, arguments in (
            ("tube.abc: the file name must end in .mdd or .pc2", (self.folder / "tube.abc", 1, 5)),
            (
                f"{path} cannot be written (No such file or directory): choose another folder or another name",
                (path, 1, 5),
            ),
            ("The last frame 1 is before the first, 5: swap them", (self.mdd, 5, 1)),
            (
                "//tube.mdd is beside the .blend file, which is not saved yet; save it or name a whole path",
                ("//tube.mdd", 1, 5),
            ),
        ):
            self.assert_error(ValueError, message, self.api.export_mesh_cache, obj, *arguments)
        self.assertEqual(module("core.sessions").locked_by(uid("Tube")), "")
        bpy.ops.wm.save_as_mainfile(filepath=str(self.folder / "scene.blend"))
        obj = bpy.data.objects["Tube"]
        filepaths = bpy.context.preferences.filepaths
        self.addCleanup(setattr, filepaths, "use_relative_paths", True)
        for is_relative, expected in ((True, "//tube.mdd"), (False, str(self.mdd))):
            filepaths.use_relative_paths = is_relative
            self.api.export_mesh_cache(obj, "//tube.mdd", 1, 5, add_modifier=True)
            self.assertEqual(obj.modifiers[0].filepath, expected)
            self.assertTrue(self.mdd.is_file())

    def test_a_cancelled_export_leaves_nothing(self):
        obj = animated()
        self.mdd.write_text("older")
        before = data_of(obj)
        message = "The export of 'Tube' was cancelled; nothing has changed"
        export = self.api.export_mesh_cache
        self.assert_error(self.api.Cancelled, message, export, obj, self.mdd, 1, 21, 1, lambda done: done < 0.5)
        self.assertEqual(data_of(obj), before)
        self.assertEqual([p.name for p in self.folder.iterdir()], ["tube.mdd"])
        self.assertEqual(self.mdd.read_text(), "older")
        self.assertEqual(len(obj.modifiers), 0)

    def test_the_operator(self):
        obj = animated()
        bpy.context.view_layer.objects.active = obj
        path = self.folder / "tube.pc2"
        done = bpy.ops.arap.export_mesh_cache(filepath=str(path), cache_format="PC2", frame_start=1, frame_end=4)
        self.assertEqual(done, {"FINISHED"})
        self.assertEqual(obj.modifiers[0].cache_format, "PC2")
        self.assertEqual(path.stat().st_size, 32 + 4 * len(obj.data.vertices) * 12)

    def test_what_goes_along_is_not_in_it_and_told(self):
        obj, other = animated(), mesh_object("Shirt")
        self.api.attach(obj, [other])
        job = module("bake.cache").MeshCacheJob(obj, self.mdd, 1, 3)
        self.addCleanup(job.cancel)
        self.assertEqual(job.warning, "What is attached is not in the cache, but in Bake Animation: Shirt")

    def test_other_shape_keys_are_not_in_it(self):
        obj = animated()
        shapes = self.baked_shapes(obj, 1, 3)
        own_key(obj, "Smile", 1.0)
        self.api.export_mesh_cache(obj, self.mdd, 1, 3, add_modifier=True)
        self.check_frames(obj, shapes, (1, 2, 3))
