# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach: what the artist does to hosts and attachments."""

import numpy as np
from clothes import AttachTest, sleeve
from looks import in_world, key_names, key_positions, rest_positions, shown_positions
from support import bpy, module, opened_again
from tubes import Matrix, bend, posable, solved


class ChangesTest(AttachTest):
    def test_an_edited_follower_or_body_is_bound_again(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        for edited in (target, host):
            bpy.context.view_layer.objects.active = edited
            bpy.ops.object.mode_set(mode="EDIT")
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.mesh.subdivide()
            bpy.ops.object.mode_set(mode="OBJECT")
            bpy.context.view_layer.update()
            self.assertEqual(self.problem(host), "")
            self.assert_follows(host, target)

    def test_another_uneven_scale_of_the_body_binds_again(self):
        host, target = posable(), sleeve()
        target.parent = host
        self.api.attach(host, [target])
        bend(host)
        self.api.solve(host)
        former = self.carried(host, target)
        host.scale = (1.0, 1.0, 3.0)
        bpy.context.view_layer.update()
        self.assertGreater(np.abs(self.carried(host, target) - former).max(), 0.01)
        self.assert_follows(host, target)

    def test_after_object_apply_nothing_has_moved(self):
        """To the attachment, to the host, and to both: coordinates and matrices say the same in other numbers."""
        scale = Matrix.Diagonal((1.0, 2.0, 1.0, 1.0))
        for applied in (["Sleeve"], ["Tube"], ["Sleeve", "Tube"]):
            self.setUp()
            host, target = posable(), sleeve(Matrix.Translation((0.0, 0.0, 0.5)) @ scale)
            host.scale = (1.0, 2.0, 1.0)
            bpy.context.view_layer.update()
            self.api.attach(host, [target])
            shape = np.array(rest_positions(host) + 0.1 * rest_positions(host)[:, ::-1], np.float32)
            key = module("scene.pose_key").ensure(host)
            key.value = 1.0
            module("scene.shape_keys").write(host, key, shape)
            bpy.context.view_layer.update()
            before = in_world(target, shown_positions(target))
            with bpy.context.temp_override(selected_editable_objects=[bpy.data.objects[name] for name in applied]):
                bpy.ops.object.transform_apply()
            bpy.context.view_layer.update()
            target = opened_again() and bpy.data.objects["Sleeve"]
            host = bpy.data.objects["Tube"]
            self.assert_close(in_world(target, shown_positions(target)), before, 1e-5)
            module("scene.shape_keys").write(host, module("scene.pose_key").find(host), key_positions(host))
            bpy.context.view_layer.update()
            self.assert_close(in_world(target, shown_positions(target)), before, 0.02)

    def test_another_mesh_under_a_followers_name_is_bound(self):
        """Two attachments of as many vertices have swapped their names."""
        host, first, second = solved(), sleeve(), sleeve(Matrix.Translation((0.0, 0.0, 1.0)), "Cuff")
        self.api.attach(host, [first, second])
        shown = [shown_positions(obj) for obj in (first, second)]
        first.name, second.name, first.name = "Other", "Sleeve", "Cuff"
        self.api.solve(host)
        for obj, positions in zip((first, second), shown, strict=True):
            self.assert_close(shown_positions(obj), positions)

    def test_copies_of_body_and_follower_go_along_with_each_other(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in (host, target))
        bpy.ops.object.duplicate()
        copy, copied_target = bpy.data.objects["Tube.001"], bpy.data.objects["Sleeve.001"]
        self.assertEqual((copy.arap.attachments[0].object, copied_target.arap.attached_to.host), (copied_target, copy))
        self.api.reset_pose(copy)
        self.assert_at_rest(copied_target)
        self.assert_follows(host, target)
        self.api.bake_pose(copy, "Rest")
        copy.data.shape_keys.key_blocks["ARAP"].value = 0.5
        bpy.context.view_layer.update()
        self.assertAlmostEqual(copied_target.data.shape_keys.key_blocks["ARAP"].value, 0.5, places=6)

    def test_a_part_separated_from_a_follower_is_told_and_taken(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
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
        text = module("attach.problems").left_out_text
        expected = "This is a copy of something that follows 'Tube': select it, Shift-click that, and press Attach"
        self.assertEqual([text(obj) for obj in (host, target, part)], ["", "", expected])
        self.api.attach(host, [part])
        self.api.solve(host)
        for obj in (target, part):
            self.assert_follows(host, obj)
        self.assertEqual(key_names(part), key_names(host))

    def test_a_copy_of_the_body_moves_nothing_of_the_original(self):
        host, target = posable(), sleeve()
        self.api.attach(host, [target])
        copy = host.copy()
        copy.data = host.data.copy()
        self.scene.collection.objects.link(copy)
        bpy.context.view_layer.update()
        self.assertEqual(
            self.problem(copy), "'Sleeve' is attached to 'Tube': press Attach, or remove it from this list"
        )
        bend(host)
        self.api.solve(host)
        shown = shown_positions(target)
        self.api.copy_handles(copy)
        self.api.reset_handles(copy)
        self.api.solve(copy)
        self.assert_close(shown_positions(target), shown, 0.0)
        module("attach.attachments").detach_at(copy, 0)
        self.assertEqual(target.arap.attached_to.host, host)

    def test_a_renamed_follower_goes_along_and_a_deleted_one_is_forgotten(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        target.name = "Shirt"
        bend(host)
        self.api.solve(host)
        self.assert_follows(host, target)
        bpy.data.objects.remove(target)
        bpy.context.view_layer.update()
        states = module("attach.states").all_states()
        self.assertFalse(any(state.wrap is not None for state in states.values()))

    def test_a_hidden_follower_is_written_too(self):
        """In a window a little later; without one, at once."""
        host, target = posable(), sleeve()
        self.api.attach(host, [target])
        target.hide_set(True)
        bend(host)
        self.api.solve(host)
        target.hide_set(False)
        self.assert_follows(host, target)
