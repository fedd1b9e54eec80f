# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of a mesh: whose handles they have, and how they get their own."""

from unittest import mock

from looks import key_positions
from support import SceneTest, bpy, module
from tubes import MIDDLE, TOP, animate, bend, copied, empty_at, move, posable, solved


class HandleCopiesTest(SceneTest):
    def test_a_copy_is_refused_until_it_has_handles_of_its_own(self):
        obj = solved()
        copy = copied(obj)
        reason = "Handle 'Head' of 'Tube.001': its empty belongs to 'Tube', of which this is a copy; press Copy Handles"
        self.assert_error(ValueError, reason, self.api.solve, copy)
        self.api.store_pose(obj, "Bent")
        place = obj.arap.handles[0].target.matrix_world.copy()
        size = obj.arap.handles[0].target.empty_display_size
        self.api.reset_handles(copy)
        copy.arap.handle_size = 3.0
        self.assertEqual(obj.arap.handles[0].target.matrix_world, place)
        self.assertEqual(obj.arap.handles[0].target.empty_display_size, size)
        bpy.context.view_layer.objects.active = copy
        self.assertEqual(bpy.ops.arap.handles_copy(), {"FINISHED"})
        self.assertFalse(bpy.ops.arap.handles_copy.poll())
        twin = copy.arap.handles[0].target
        self.assertEqual(
            (twin.parent, twin.users_scene, copy.arap.handles[0].has_made_target), (copy, (self.scene,), True)
        )
        self.api.solve(copy)
        self.assert_close(key_positions(copy), key_positions(obj), 1e-5)
        self.assert_error(
            ValueError,
            "'Tube' has handles of its own, and none was deleted: there is nothing to copy",
            self.api.copy_handles,
            obj,
        )

    def test_a_deleted_empty_comes_back(self):
        obj = solved()
        posed = key_positions(obj)
        head = obj.arap.handles[0].target
        bpy.context.view_layer.objects.active = obj
        self.assertFalse(bpy.ops.arap.handles_copy.poll())
        self.scene.collection.objects.unlink(head)  # what Delete does
        bpy.context.view_layer.update()
        reason = "Handle 'Head' of 'Tube': its empty is not in the scene; press Copy Handles or remove the handle"
        self.assert_error(ValueError, reason, self.api.solve, obj)
        self.assertEqual(bpy.ops.arap.handles_copy(), {"FINISHED"})
        self.assertEqual((obj.arap.handles[0].target, head.users_scene), (head, (self.scene,)))
        bpy.context.view_layer.update()
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 1e-5)

    def test_redraws_do_not_look_at_the_scene_again(self):
        """Which handles are foreign takes a look at every object of the file."""
        copy = copied(posable())
        ui_cache = module("scene.ui_cache")
        with mock.patch.object(module("scene.handle_motion"), "foreign_handles", return_value=[1]) as look:
            for _ in range(3):
                self.assertTrue(ui_cache.has_foreign_handles(copy))
            self.assertEqual(look.call_count, 1)
            copy.location.x += 1.0
            bpy.context.view_layer.update()
            ui_cache.has_foreign_handles(copy)
            self.assertEqual(look.call_count, 2)

    def test_handles_under_handles_and_animations_are_copied_too(self):
        obj = posable()
        other = obj.arap.controls[self.api.add_handle(obj, MIDDLE, name="Waist")].target
        head, between = obj.arap.handles[0].target, empty_at((0.0, 0.0, 1.0), "Between")
        for child, parent in ((between, obj), (other, between), (head, other)):
            matrix = child.matrix_world.copy()
            child.parent = parent
            child.matrix_world = matrix
            bpy.context.view_layer.update()
        animate(obj)
        copy = copied(obj)
        copy.location.x += 10.0
        bpy.context.view_layer.update()
        twins = self.api.copy_handles(copy)
        self.assertEqual([twin.parent for twin in twins], [twins[1], copy])
        self.assertNotEqual(twins[0].animation_data.action, head.animation_data.action)
        for frame in (1, 11):
            self.scene.frame_set(frame)
            motions = [module("scene.handle_motion").handle_matrices(item) for item in (obj, copy)]
            self.assert_close(*motions, 1e-5)

    def test_an_empty_without_its_original_or_chosen_by_hand_belongs_to_all(self):
        obj, other = posable(), empty_at((0.0, 0.0, 4.0))
        copy = copied(obj)
        for tube in (obj, copy):
            tube.arap.handles[0].target = other
        move(other, (0.0, 0.5, 0.0))
        for tube in (obj, copy):
            self.api.solve(tube)
        obj = posable("Second")
        copy = copied(obj)
        bpy.data.objects.remove(obj)
        bend(copy)
        self.api.solve(copy)

    def test_a_pasted_mesh_gets_its_handles_into_the_scene(self):
        obj = solved()
        posed = key_positions(obj)
        obj.select_set(True)
        self.assertIn("FINISHED", bpy.ops.view3d.copybuffer())
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        bpy.ops.view3d.pastebuffer()
        obj = bpy.data.objects["Tube"]
        bpy.context.view_layer.update()
        if not obj.arap.handles[0].target.users_scene:
            self.api.copy_handles(obj)
        bpy.context.view_layer.update()
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 1e-5)
        self.assert_close(key_positions(obj)[TOP], posed[TOP], 1e-6)
