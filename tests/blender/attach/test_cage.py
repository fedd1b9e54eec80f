# SPDX-License-Identifier: GPL-3.0-or-later
"""Make Cage: a closed mesh around the mesh moves all of it, by Blender's Mesh Deform."""

from unittest import mock

import numpy as np
from looks import rest_positions, shown_positions
from mathutils import Matrix
from support import SceneTest, bpy, module
from tubes import BOTTOM, PLACED, TOP, bend, mesh_object, posable, solved

NEAR = 1e-4  # of the tube 4 long: as near as Mesh Deform brings a mesh that its cage moves as a whole


def positions_of(cage):
    return np.array([vertex.co[:] for vertex in cage.data.vertices])


def shift(cage, *way, above=-np.inf):
    """Moves its vertices above a height."""
    positions = positions_of(cage)
    positions[positions[:, 2] > above] += way
    cage.data.vertices.foreach_set("co", positions.ravel())
    cage.data.update_tag()
    bpy.context.view_layer.update()


class CageTest(SceneTest):
    def test_it_is_around_the_mesh_and_leaves_it_in_place(self):
        for matrix in (None, PLACED):
            obj = mesh_object(matrix=matrix)
            cage = self.api.make_cage(obj)
            self.assertEqual((cage.name, cage.parent), ("Tube Cage", obj))
            self.assertEqual((cage.display_type, cage.hide_render), ("WIRE", True))
            self.assertTrue(all((*cage.lock_location, *cage.lock_rotation, *cage.lock_scale)))
            self.assertEqual(list(cage.users_collection), list(obj.users_collection))
            corners, rest = positions_of(cage), rest_positions(obj)
            self.assertTrue((corners.min(axis=0) < rest.min(axis=0)).all())
            self.assertTrue((corners.max(axis=0) > rest.max(axis=0)).all())
            self.assertLess(len(corners), 300)
            self.assert_close(shown_positions(obj), rest, NEAR)
            for left in (cage, obj):
                bpy.data.objects.remove(left)

    def test_the_mesh_moves_with_all_of_the_cage_and_with_a_part(self):
        for matrix in (None, PLACED):
            obj = mesh_object(matrix=matrix)
            cage, rest = self.api.make_cage(obj), rest_positions(obj)
            shift(cage, 0.0, 2.0, 0.0)
            self.assert_close(shown_positions(obj), rest + np.array([0.0, 2.0, 0.0]), NEAR)
            shift(cage, 0.0, -2.0, 0.0)
            shift(cage, 1.0, 0.0, 0.0, above=3.0)
            moved = shown_positions(obj) - rest
            self.assert_close(moved[TOP], np.tile([1.0, 0.0, 0.0], (len(TOP), 1)), 0.2)
            self.assert_close(moved[BOTTOM], np.zeros((len(BOTTOM), 3)), 0.1)
            for left in (cage, obj):
                bpy.data.objects.remove(left)

    def test_around_a_pose_it_leaves_the_pose_and_later_poses_add_to_it(self):
        obj = solved()
        posed = shown_positions(obj)
        cage = self.api.make_cage(obj)
        self.assert_close(shown_positions(obj), posed, NEAR)
        shift(cage, 1.0, 0.0, 0.0)
        self.api.reset_pose(obj)
        self.assert_close(shown_positions(obj), rest_positions(obj) + np.array([1.0, 0.0, 0.0]), NEAR)

    def test_all_shape_keys_that_show_are_inside(self):
        obj = mesh_object()
        obj.shape_key_add(name="Basis")
        key = obj.shape_key_add(name="Far")
        for point in key.data:
            point.co.x += 6.0
        key.value = 1.0
        cage, before = self.api.make_cage(obj), shown_positions(obj)
        shift(cage, 0.0, 2.0, 0.0)
        self.assert_close(shown_positions(obj), before + np.array([0.0, 2.0, 0.0]), NEAR)

    def test_the_cage_is_posed_as_any_mesh(self):
        obj = mesh_object()
        cage = self.api.make_cage(obj)
        height = positions_of(cage)[:, 2]
        self.api.add_pin(cage, np.flatnonzero(height < height.min() + 0.5), name="Feet")
        handle = cage.arap.controls[self.api.add_handle(cage, np.flatnonzero(height > height.max() - 0.5), name="Head")]
        handle.target.location.x += 1.0
        self.api.solve(cage)
        moved = shown_positions(obj) - rest_positions(obj)
        self.assertGreater(moved[TOP, 0].mean(), 0.7)
        self.assertLess(np.abs(moved[BOTTOM]).max(), 0.3)

    def test_other_modifiers_come_after_it_but_a_mirror_that_completes_the_mesh(self):
        obj = mesh_object()
        obj.modifiers.new("Subdivision", "SUBSURF")
        self.api.make_cage(obj)
        self.assertEqual([m.type for m in obj.modifiers], ["MESH_DEFORM", "SUBSURF"])
        half = mesh_object("Half")
        half.data.transform(Matrix.Rotation(1.5707963, 4, "Y"))  # along x, from the plane
        half.modifiers.new("Mirror", "MIRROR").use_clip = True
        before = shown_positions(half)
        cage = self.api.make_cage(half)
        self.assertEqual([m.type for m in half.modifiers], ["MIRROR", "MESH_DEFORM"])
        corners = positions_of(cage)
        self.assertLess(corners[:, 0].min(), -0.9 * corners[:, 0].max(), "it is around both halves")
        shift(cage, 0.0, 0.0, 1.0)
        self.assert_close(shown_positions(half), before + np.array([0.0, 0.0, 1.0]), NEAR)

    def test_it_is_first_where_viewport_and_render_differ(self):
        obj = mesh_object()
        obj.data.transform(Matrix.Rotation(1.5707963, 4, "Y"))
        mirror = obj.modifiers.new("Mirror", "MIRROR")
        mirror.use_clip, mirror.show_viewport = True, False
        self.api.make_cage(obj)
        self.assertEqual([m.type for m in obj.modifiers], ["MESH_DEFORM", "MIRROR"])

    def test_what_it_does_not_move_is_told(self):
        host, shirt = mesh_object(), mesh_object("Shirt")
        self.api.attach(host, [shirt])
        job = module("attach.cage").CageJob(host, 3)
        self.assertEqual(job.warning, "What is attached to 'Tube' does not follow its cage")
        job.cancel()
        host.arap.is_stand_in = True
        message = "'Tube' stands for meshes that a cage would not move: make a cage around each of them"
        self.assert_error(ValueError, message, self.api.make_cage, host)

    def test_nothing_is_made_if_that_is_cancelled_fails_or_the_mesh_goes(self):
        obj = posable()
        bend(obj)
        objects, meshes = list(bpy.data.objects), list(bpy.data.meshes)
        make = module("attach.cage")
        make.CageJob(obj, 3).cancel()
        message = "Blender could not bind 'Tube' to its cage: make one with more Cells"
        with mock.patch.object(make, "_bind", return_value=False):
            self.assert_error(RuntimeError, message, self.api.make_cage, obj)
        collection = obj.users_collection[0]
        collection.objects.unlink(obj)
        message = "'Tube' is disabled in viewports or excluded from the view layer: enable it, or hide it with the eye"
        self.assert_error(ValueError, message, self.api.make_cage, obj)
        collection.objects.link(obj)
        self.assertEqual((list(bpy.data.objects), list(bpy.data.meshes)), (objects, meshes))
        job = make.CageJob(obj, 3)
        obj.data.vertices.add(1)
        message = (
            "The mesh of 'Tube' has changed (136 vertices and 130 faces, now 137 and 130) while its cage was made: "
            "start again"
        )
        self.assert_error(RuntimeError, message, module("core.job").run_job, job)
        job = make.CageJob(obj, 3)
        bpy.data.objects.remove(obj)
        self.assert_error(RuntimeError, "'Tube' is gone: its cage was not made", module("core.job").run_job, job)

    def test_the_operator_selects_the_cage_which_is_then_the_mesh_in_hand(self):
        obj = mesh_object()
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(bpy.ops.arap.cage_make(cells=4), {"FINISHED"})
        cage = bpy.context.object
        self.assertEqual((cage.name, cage.select_get()), ("Tube Cage", True))
        self.assertEqual(module("ui.checks").arap_object(bpy.context), cage)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.context.view_layer.objects.active = cage
        self.assertFalse(bpy.ops.arap.cage_make.poll())

    def test_what_has_no_cage_is_refused(self):
        self.assert_error(ValueError, "'Nothing' is not a mesh: choose a mesh object", self.api.make_cage, None)
        obj = mesh_object()
        with self.assertRaisesRegex(ValueError, "cells"):
            self.api.make_cage(obj, cells=1)
        self.assertEqual(list(bpy.data.objects), [obj])
