# SPDX-License-Identifier: GPL-3.0-or-later
"""Follow: on by itself from the first handle, ended by Keep and Cancel."""

from looks import key_positions, rest_positions, shown_positions
from support import SceneTest, bpy, module, opened_again
from tubes import BOTTOM, MIDDLE, TOP, copied, mesh_object, posable, select_in_edit_mode


class FollowTest(SceneTest):
    """From the first handle on the mesh follows; Keep and Cancel end it."""

    def setUp(self) -> None:
        super().setUp()
        self.obj = mesh_object()
        self.api.add_pin(self.obj, BOTTOM)
        bpy.context.view_layer.objects.active = self.obj
        self.add(TOP)

    def add(self, vertices):
        select_in_edit_mode(self.obj, vertices)
        bpy.ops.arap.handle_add()
        bpy.ops.arap.edit_mesh()

    def move_handle(self):
        self.obj.arap.handles[0].target.location.x += 1.0
        bpy.context.view_layer.update()

    def test_on_from_the_first_handle_and_not_again_once_it_was_switched_off(self):
        self.assertTrue(self.obj.arap.is_live)
        self.obj.arap.is_live = False
        self.add(MIDDLE)
        self.assertFalse(self.obj.arap.is_live)

    def test_keep_leaves_the_pose(self):
        self.move_handle()
        posed = shown_positions(self.obj)
        bpy.ops.arap.follow_end(is_kept=True)
        self.assertFalse(self.obj.arap.is_live)
        self.assert_close(shown_positions(self.obj), posed, 0.0)
        self.assertEqual(self.obj.arap.handles[0].target.location.x, 1.0)
        self.assertFalse(bpy.ops.arap.follow_end.poll())

    def test_cancel_puts_mesh_and_handles_back(self):
        rest = shown_positions(self.obj)
        self.move_handle()
        self.assertGreater(abs(shown_positions(self.obj) - rest).max(), 0.5)
        bpy.ops.arap.follow_end(is_kept=False)
        self.assertFalse(self.obj.arap.is_live)
        self.assert_close(shown_positions(self.obj), rest, 1e-6)
        self.assertAlmostEqual(self.obj.arap.handles[0].target.location.x, 0.0)

    def test_the_key_is_made_at_rest_when_it_begins_and_cancel_takes_it_away(self):
        obj = posable("Second")
        obj.arap.is_live = True
        self.assertEqual(obj.data.shape_keys.key_blocks["ARAP"].value, 0.0)
        self.assert_close(key_positions(obj), rest_positions(obj), 0.0)
        bpy.context.view_layer.objects.active = obj
        bpy.ops.arap.follow_end(is_kept=False)
        self.assertIsNone(obj.data.shape_keys)

    def test_cancel_works_under_another_name(self):
        rest = shown_positions(self.obj)
        self.move_handle()
        self.obj.name = "Figure"
        bpy.context.view_layer.update()
        self.assertEqual((self.obj.arap.is_live, self.obj.arap.live_problem), (True, ""))
        bpy.ops.arap.follow_end(is_kept=False)
        self.assert_close(shown_positions(self.obj), rest, 1e-6)

    def test_cancel_finds_what_was_renamed(self):
        """By the list, which renames the empty and the group too, and by hand."""
        rest = shown_positions(self.obj)
        self.add(MIDDLE)
        handles = self.obj.arap.handles
        self.obj.arap.is_live = False
        self.obj.arap.is_live = True
        for handle in handles:
            handle.target.location.x += 1.0
        bpy.context.view_layer.update()
        handles[0].name = "Head"
        handles[1].target.name = "Belly"
        bpy.context.view_layer.update()
        self.assertEqual((self.obj.arap.is_live, self.obj.arap.live_problem), (True, ""))
        bpy.ops.arap.follow_end(is_kept=False)
        self.assert_close([handle.target.location.x for handle in handles], [0.0, 0.0])
        self.assert_close(shown_positions(self.obj), rest, 1e-6)
        self.api.solve(self.obj)
        self.assert_close(shown_positions(self.obj), rest)

    def test_cancel_after_an_undo_goes_back_to_the_start_of_that_step(self):
        """Undo brings the object's number of that step."""
        number = self.obj.arap.follow_start
        self.move_handle()
        bpy.ops.arap.follow_end(is_kept=True)
        self.obj.arap.is_live = True
        self.assertNotEqual(self.obj.arap.follow_start, number)
        self.obj.arap.follow_start = number
        bpy.ops.arap.follow_end(is_kept=False)
        self.assertAlmostEqual(self.obj.arap.handles[0].target.location.x, 0.0)

    def test_a_copy_and_a_new_mesh_of_the_name_have_no_start(self):
        has_start = module("pose.starts").has_start
        copy = copied(self.obj)
        self.assertEqual((has_start(self.obj), has_start(copy)), (True, False))
        bpy.data.objects.remove(self.obj)
        other = mesh_object("Other")
        other.name = "Tube"
        self.assertFalse(has_start(other))

    def test_the_last_few_starts_are_kept(self):
        starts = module("pose.starts")
        for _ in range(2 * starts.MOST_STARTS):
            self.obj.arap.is_live = False
            self.obj.arap.is_live = True
        self.assertEqual(len(starts._starts), starts.MOST_STARTS)
        self.assertTrue(starts.has_start(self.obj))

    def test_cancel_after_a_file_was_opened_says_why_it_cannot(self):
        obj = opened_again()
        self.assertTrue(obj.arap.is_live)
        with self.assertRaisesRegex(
            RuntimeError, "'Tube' followed when the file was opened: use Reset Handles, or Keep"
        ):
            bpy.ops.arap.follow_end(is_kept=False)
        self.assertTrue(obj.arap.is_live)
