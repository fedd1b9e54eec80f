# SPDX-License-Identifier: GPL-3.0-or-later
"""Cages: a closed mesh around the mesh moves all of it."""

import bmesh
import numpy as np
from looks import key_positions, rest_positions, shown_positions
from mathutils import Matrix
from support import SceneTest, bpy, module, opened_again
from tubes import PLACED, TOP, mesh_object, move, posable

TURNED = Matrix.Translation((1.0, 2.0, 3.0)) @ Matrix.Rotation(0.6, 4, "X")


def box(obj, size=3.0, name="Box"):
    """A cube of quads around the tube, an object of its own."""
    bpy.ops.mesh.primitive_cube_add(size=size, location=obj.matrix_world.translation)
    cage = bpy.context.object
    cage.name = name
    cage.data.transform(Matrix.Diagonal((1.0, 1.0, 2.0, 1.0)) @ Matrix.Translation((0.0, 0.0, 1.0)))
    bpy.context.view_layer.update()
    return cage


def edit(cage, change):
    """Changes the vertices of a cage in Edit Mode, and stays in it."""
    bpy.context.view_layer.objects.active = cage
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(cage.data)
    for vertex in edited.verts:
        change(vertex)
    bmesh.update_edit_mesh(cage.data)
    bpy.context.view_layer.update()


def lift(vertex):
    if vertex.co.z > 2.0:
        vertex.co.x += 1.0


class CageTest(SceneTest):
    def following(self, **options):
        obj = mesh_object()
        handle = self.api.make_cage(obj, **options)
        obj.arap.is_live = True
        bpy.context.view_layer.update()
        return obj, handle.target

    def test_a_made_cage_is_around_the_mesh_and_leaves_it_in_place(self):
        for matrix in (None, PLACED):
            obj = mesh_object(matrix=matrix)
            handle = self.api.make_cage(obj)
            cage = handle.target
            self.assertEqual((handle.name, cage.name, cage.parent), ("Tube Cage", "Tube Cage", obj))
            self.assertEqual((cage.display_type, cage.hide_render), ("WIRE", True))
            self.assertEqual(list(cage.users_collection), list(obj.users_collection))
            corners = np.array([v.co[:] for v in cage.data.vertices])
            rest = rest_positions(obj)
            self.assertTrue((corners.min(axis=0) < rest.min(axis=0)).all())
            self.assertTrue((corners.max(axis=0) > rest.max(axis=0)).all())
            self.api.solve(obj)
            self.assert_close(key_positions(obj), rest, 1e-6)
            self.assertLess(len(corners), 300)
            self.api.remove_handle(obj, 0)
            self.assertEqual(list(bpy.data.objects), [obj])
            bpy.data.objects.remove(obj)

    def test_the_mesh_follows_what_is_edited_in_edit_mode(self):
        obj, cage = self.following()
        edit(cage, lift)
        self.assertEqual((obj.arap.is_live, obj.arap.live_problem), (True, ""))
        self.assert_close(shown_positions(obj)[TOP], rest_positions(obj)[TOP] + (1.0, 0.0, 0.0), 0.1)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.assert_close(shown_positions(obj)[TOP], rest_positions(obj)[TOP] + (1.0, 0.0, 0.0), 0.1)

    def test_it_follows_the_object_of_the_cage_exactly(self):
        for coordinates in ("mean_value", "harmonic", "green"):
            with self.subTest(coordinates):
                obj, cage = self.following(coordinates=coordinates)
                cage.matrix_local = TURNED
                bpy.context.view_layer.update()
                turned = np.array(TURNED)
                expected = rest_positions(obj) @ turned[:3, :3].T + turned[:3, 3]
                self.assert_close(shown_positions(obj), expected, 1e-4)
                self.setUp()
