# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry Along: what the artist does to bodies and followers."""

import numpy as np
from clothes import CarryTest, sleeve
from looks import in_world, key_names, key_positions, rest_positions, shown_positions
from support import bpy, module, opened_again
from tubes import Matrix, bend, posable, solved


class ChangesTest(CarryTest):
    def test_an_edited_follower_or_body_is_bound_again(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        for edited in (target, body):
            bpy.context.view_layer.objects.active = edited
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.mesh.subdivide()
            bpy.ops.object.mode_set(mode="OBJECT")
            bpy.context.view_layer.update()
            self.assertEqual(self.problem(body), "")
            self.assert_goes_along(body, target)

    def test_another_uneven_scale_of_the_body_binds_again(self):
        body, target = posable(), sleeve()
        target.parent = body
        self.api.carry_along(body, [target])
        bend(body)
        self.api.solve(body)
        former = self.carried(body, target)
        body.scale = (1.0, 1.0, 3.0)
        bpy.context.view_layer.update()
        self.assertGreater(np.abs(self.carried(body, target) - former).max(), 0.01)
        self.assert_goes_along(body, target)

    def test_after_object_apply_nothing_has_moved(self):
        """To the follower, to the body, and to both: coordinates and matrices say the same in other numbers."""
        scale = Matrix.Diagonal((1.0, 2.0, 1.0, 1.0))
        for applied in (["Sleeve"], ["Tube"], ["Sleeve", "Tube"]):
            self.setUp()
            body, target = posable(), sleeve(Matrix.Translation((0.0, 0.0, 0.5)) @ scale)
            body.scale = (1.0, 2.0, 1.0)
            bpy.context.view_layer.update()
            self.api.carry_along(body, [target])
            shape = np.array(rest_positions(body) + 0.1 * rest_positions(body)[:, ::-1], np.float32)
            key = module("scene.pose_key").ensure(body)
            key.value = 1.0
            module("scene.shape_keys").write(body, key, shape)
            bpy.context.view_layer.update()
            before = in_world(target, shown_positions(target))
            with bpy.context.temp_override(selected_editable_objects=[bpy.data.objects[name] for name in applied]):
                bpy.ops.object.transform_apply()
            bpy.context.view_layer.update()
            target = opened_again() and bpy.data.objects["Sleeve"]
            body = bpy.data.objects["Tube"]
            self.assert_close(in_world(target, shown_positions(target)), before, 1e-5)
            module("scene.shape_keys").write(body, module("scene.pose_key").find(body), key_positions(body))
            bpy.context.view_layer.update()
            self.assert_close(in_world(target, shown_positions(target)), before, 0.02)

    def test_another_mesh_under_a_followers_name_is_bound(self):
        """Two followers of as many vertices have swapped their names."""
        body, first, second = solved(), sleeve(), sleeve(Matrix.Translation((0.0, 0.0, 1.0)), "Cuff")
        self.api.carry_along(body, [first, second])
        shown = [shown_positions(obj) for obj in (first, second)]
        first.name, second.name, first.name = "Other", "Sleeve", "Cuff"
        self.api.solve(body)
        for obj, positions in zip((first, second), shown, strict=True):
            self.assert_close(shown_positions(obj), positions)

    def test_copies_of_body_and_follower_go_along_with_each_other(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in (body, target))
        bpy.ops.object.duplicate()
        copy, copied_target = bpy.data.objects["Tube.001"], bpy.data.objects["Sleeve.001"]
        self.assertEqual((copy.arap.followers[0].target, copied_target.arap.carried.body), (copied_target, copy))
        self.api.reset_pose(copy)
        self.assert_at_rest(copied_target)
        self.assert_goes_along(body, target)
        self.api.bake_pose(copy, "Rest")
        copy.data.shape_keys.key_blocks["ARAP"].value = 0.5
        bpy.context.view_layer.update()
        self.assertAlmostEqual(copied_target.data.shape_keys.key_blocks["ARAP"].value, 0.5, places=6)

    def test_a_part_separated_from_a_follower_is_told_and_taken(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        bpy.context.view_layer.objects.active = target
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="DESELECT")
        bpy.ops.object.mode_set(mode="OBJECT")
        for face in list(target.data.polygons)[:16]:
            face.select = True
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.separate(type="SELECTED")
        bpy.ops.object.mode_set(mode="OBJECT")
        part = bpy.data.objects["Sleeve.001"]
        text = module("carry.problems").left_out_text
        expected = "It came from what goes along with 'Tube', and does not: select it, then that, and Carry Along"
        self.assertEqual([text(obj) for obj in (body, target, part)], ["", "", expected])
        self.api.carry_along(body, [part])
        self.api.solve(body)
        for obj in (target, part):
            self.assert_goes_along(body, obj)
        self.assertEqual(key_names(part), key_names(body))

    def test_a_copy_of_the_body_moves_nothing_of_the_original(self):
        body, target = posable(), sleeve()
        self.api.carry_along(body, [target])
        copy = body.copy()
        copy.data = body.data.copy()
        self.scene.collection.objects.link(copy)
        bpy.context.view_layer.update()
        self.assertEqual(
            self.problem(copy), "'Sleeve' goes along with 'Tube': press Carry Along, or remove it from this list"
        )
        bend(body)
        self.api.solve(body)
        shown = shown_positions(target)
        self.api.copy_handles(copy)
        self.api.reset_handles(copy)
        self.api.solve(copy)
        self.assert_close(shown_positions(target), shown, 0.0)
        module("carry.lists").remove_at(copy, 0)
        self.assertEqual(target.arap.carried.body, body)

    def test_a_renamed_follower_goes_along_and_a_deleted_one_is_forgotten(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        target.name = "Shirt"
        bend(body)
        self.api.solve(body)
        self.assert_goes_along(body, target)
        bpy.data.objects.remove(target)
        bpy.context.view_layer.update()
        self.assertEqual(module("carry.wraps").uids(), [])

    def test_a_hidden_follower_is_written_too(self):
        """In a window a little later; without one, at once."""
        body, target = posable(), sleeve()
        self.api.carry_along(body, [target])
        target.hide_set(True)
        bend(body)
        self.api.solve(body)
        target.hide_set(False)
        self.assert_goes_along(body, target)
