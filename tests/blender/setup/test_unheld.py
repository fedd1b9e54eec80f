# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of the mesh without a pin or handle."""

from unittest import mock

import numpy as np
from looks import key_positions, rest_positions
from support import SceneTest, bpy, module
from tubes import BOTTOM, TOP, mesh_object, move, posable


class UnheldTest(SceneTest):
    def three_tubes_and_a_loose_vertex(self):
        """The first has a pin and a handle."""
        tubes = [mesh_object(name) for name in ("Tube", "Second", "Third")]
        tubes[1].location.x, tubes[2].location.x = 3.0, 6.0
        loose = bpy.data.meshes.new("Loose")
        loose.from_pydata([(9.0, 0.0, 0.0)], [], [])
        last = bpy.data.objects.new("Loose", loose)
        bpy.context.scene.collection.objects.link(last)
        bpy.context.view_layer.update()
        for obj in (*tubes, last):
            obj.select_set(True)
        bpy.context.view_layer.objects.active = tubes[0]
        bpy.ops.object.join()
        obj = tubes[0]
        self.api.add_pin(obj, BOTTOM)
        self.api.add_handle(obj, TOP)
        return obj

    def test_they_are_found_counted_and_selected(self):
        obj = self.three_tubes_and_a_loose_vertex()
        n = (len(obj.data.vertices) - 1) // 3
        move(obj.arap.handles[0].target, (1.0, 0.0, 0.0))
        stats = self.api.solve(obj)
        vertices, n_parts = module("setup.free_parts").find(obj, bpy.context.evaluated_depsgraph_get())
        self.assertEqual((n_parts, 1), (stats.parts_at_rest, stats.loose_vertices))
        self.assert_close(key_positions(obj)[vertices], rest_positions(obj)[vertices], 4e-6)
        np.testing.assert_array_equal(vertices, np.arange(n, 3 * n + 1))
        text = module("pose.free_parts_text").free_parts_text(stats)
        self.assertEqual(text, "2 parts and 1 loose vertex have no pin or handle and do not move")
        obj.data.vertices[n].hide = True
        self.assertEqual(bpy.ops.arap.select_free_parts(), {"FINISHED"})
        self.assertEqual(obj.mode, "EDIT")
        bpy.ops.object.mode_set(mode="OBJECT")
        np.testing.assert_array_equal(module("scene.meshes").selected_vertices(obj), vertices)
        faces = [face for face in obj.data.polygons if face.select]
        self.assertEqual(len(faces), 2 * len(obj.data.polygons) // 3, "whole faces too")

    def test_nothing_is_selected_if_there_are_none(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(bpy.ops.arap.select_free_parts(), {"FINISHED"})
        self.assertEqual(obj.mode, "OBJECT")

    def test_too_little_memory_is_reported_as_other_errors_are(self):
        bpy.context.view_layer.objects.active = posable()
        problem = "the factor of this mesh needs about 12 GB"
        too_little = mock.patch.object(module("setup.free_parts"), "find", side_effect=MemoryError(problem))
        with too_little, self.assertRaises(RuntimeError) as raised:
            bpy.ops.arap.select_free_parts()
        self.assertIn(problem, str(raised.exception))
        self.assertNotIn("Traceback", str(raised.exception))

    def test_welded_seams_hold_together(self):
        """Two squares whose edges are at the same place, but for rounding."""
        mesh = bpy.data.meshes.new("Seam")
        square = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0)]
        mesh.from_pydata([*square, *((x + 1.0000002, y, z) for x, y, z in square)], [], [(0, 1, 2, 3), (4, 5, 6, 7)])
        obj = bpy.data.objects.new("Seam", mesh)
        bpy.context.scene.collection.objects.link(obj)
        bpy.context.view_layer.update()
        self.api.add_pin(obj, [0, 3])
        for is_joined, expected in ((False, 1), (True, 0)):
            obj.arap.use_weld = is_joined
            n_parts = module("setup.free_parts").find(obj, bpy.context.evaluated_depsgraph_get())[1]
            self.assertEqual((n_parts, self.api.solve(obj).parts_at_rest), (expected, expected))
