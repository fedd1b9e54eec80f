# SPDX-License-Identifier: GPL-3.0-or-later
"""Follow begins by itself with the first handle, and unticking it keeps the pose."""

from looks import key_positions, rest_positions, shown_positions
from support import SceneTest, bpy
from tubes import BOTTOM, MIDDLE, TOP, mesh_object, posable, select_in_edit_mode


class BeginTest(SceneTest):
    def test_with_the_first_handle_and_not_again_once_it_was_switched_off(self):
        obj = mesh_object()
        self.api.add_pin(obj, BOTTOM)
        for vertices in (TOP, MIDDLE):
            select_in_edit_mode(obj, vertices)
            bpy.ops.arap.handle_add()
            bpy.ops.arap.edit_mesh()
            self.assertEqual(obj.arap.use_follow, vertices is TOP)
            obj.arap.use_follow = False

    def test_the_key_is_made_at_rest_and_unticking_keeps_the_pose(self):
        obj = posable()
        obj.arap.use_follow = True
        self.assertEqual(obj.data.shape_keys.key_blocks["ARAP"].value, 0.0)
        self.assert_close(key_positions(obj), rest_positions(obj), 0.0)
        obj.arap.handles[0].target.location.x += 1.0
        bpy.context.view_layer.update()
        posed = shown_positions(obj)
        obj.arap.use_follow = False
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(obj), posed, 0.0)
        self.assertGreater(abs(posed - rest_positions(obj)).max(), 0.5)
