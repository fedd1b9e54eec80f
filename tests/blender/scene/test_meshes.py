# SPDX-License-Identifier: GPL-3.0-or-later
"""Object -> arrays: every fast way reads what the plain way reads."""

import numpy as np
from support import SceneTest, bpy, module
from tubes import mesh_object, tube_arrays


class MeshIoTest(SceneTest):
    def test_faces_and_positions(self):
        obj = mesh_object()
        positions, faces = tube_arrays()
        mesh = module("scene.meshes").read_mesh(obj)
        self.assert_close(mesh.rest_positions, positions, 1e-6)
        self.assertEqual(mesh.face_sizes.tolist(), [len(face) for face in faces])
        self.assertEqual(mesh.corner_vertices.tolist(), [vertex for face in faces for vertex in face])

    def test_rest_is_the_reference_key_not_the_mesh(self):
        obj = mesh_object()
        obj.shape_key_add(name="Basis")
        for point in obj.data.shape_keys.reference_key.data:
            point.co.x += 5.0
        rest = module("scene.meshes").read_rest(obj)
        self.assert_close(rest, tube_arrays()[0] + np.array([5.0, 0.0, 0.0]), 1e-6)

    def test_both_ways_to_read_weights_agree(self):
        compat = module("scene.versions")
        obj = mesh_object()
        n = len(obj.data.vertices)
        rng = np.random.default_rng(5)
        expected = {}
        for name in ("Feet", 'Odd "name"', "None", *(f"More {i}" for i in range(20))):
            group = obj.vertex_groups.new(name=name)
            weights = np.where(rng.random(n) < 0.5, rng.random(n), 0.0) if name != "None" else np.zeros(n)
            for vertex in np.flatnonzero(weights):
                group.add([int(vertex)], weights[vertex], "REPLACE")
            expected[name] = weights
        counts = [len(data) for data in (bpy.data.objects, bpy.data.scenes, bpy.data.node_groups, bpy.data.meshes)]
        for has_keys in (False, True):
            for use_nodes in (False, True):
                found = compat.read_group_weights(obj, list(expected), use_nodes)
                for name, weights in expected.items():
                    self.assert_close(found[name], weights, 1e-6)
            obj.shape_key_add(name="Basis" if not has_keys else "Other")
        after = [len(data) for data in (bpy.data.objects, bpy.data.scenes, bpy.data.node_groups, bpy.data.meshes)]
        self.assertEqual(after, counts)
        self.assertEqual(compat.read_group_weights(obj, []), {})

    def test_selected_vertices_in_and_out_of_edit_mode(self):
        mesh_io = module("scene.meshes")
        obj = mesh_object()
        for vertex in obj.data.vertices:
            vertex.select = vertex.index in (3, 8)
        self.assertEqual(mesh_io.selected_vertices(obj).tolist(), [3, 8])
        bpy.context.view_layer.objects.active = obj
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        self.assertEqual(len(mesh_io.selected_vertices(obj)), len(obj.data.vertices))
        bpy.ops.object.mode_set(mode="OBJECT")

    def test_modes_and_meshes_that_cannot_be_posed(self):
        check = module("scene.meshes").check_mesh
        obj = mesh_object()
        bpy.context.view_layer.objects.active = obj
        for mode, text in (("EDIT", "Edit Mode"), ("SCULPT", "Sculpt Mode")):
            bpy.ops.object.mode_set(mode=mode)
            self.assert_error(ValueError, f"'Tube' is in {text}: go back to Object Mode first", check, obj)
            bpy.ops.object.mode_set(mode="OBJECT")
        check(obj)
        points = bpy.data.objects.new("Points", bpy.data.meshes.new("Points"))
        self.assert_error(ValueError, "'Points' has no faces: there is nothing to deform", check, points)
