# SPDX-License-Identifier: GPL-3.0-or-later
"""Attach: a sleeve and an eye on the tube follow however it is posed."""

import bmesh
import numpy as np
from clothes import AttachTest, eye, sleeve
from looks import edge_lengths, key_names, key_positions, rest_positions, shown_positions
from support import bpy, module, opened_again
from tubes import PLACED, animate, animated, bend, mesh_object, own_key, posable, solved


class FollowTest(AttachTest):
    """Every way of posing."""

    def test_clothes_bend_and_eyes_keep_their_shape_under_an_uneven_scale(self):
        host = posable(matrix=PLACED)
        clothes, ball = sleeve(PLACED), eye(PLACED)
        self.api.attach(host, [clothes, ball])
        self.assertEqual([attachment.kind for attachment in host.arap.attachments], ["bend", "rigid"])
        bend(host)
        self.api.solve(host)
        for target in (clothes, ball):
            self.assert_follows(host, target)
        self.assert_close(edge_lengths(ball, shown_positions(ball)), edge_lengths(ball, rest_positions(ball)), 2e-6)

    def test_a_posed_body_takes_them_to_its_pose_at_once(self):
        host = solved()
        target = sleeve()
        self.api.attach(host, [target])
        self.assert_follows(host, target)

    def test_follow_and_playback(self):
        host, target = posable(), sleeve()
        self.api.attach(host, [target])
        host.arap.use_follow = True
        animate(host)
        for frame in (5, 11):
            self.scene.frame_set(frame)
            self.assert_follows(host, target)

    def test_what_restores_a_pose_restores_them(self):
        """Esc of Pose and of a pull."""
        host, target = posable(), sleeve()
        self.api.attach(host, [target])
        at_rest = module("pose.result").capture_state(host)
        bend(host)
        self.api.solve(host)
        bent, shown = module("pose.result").capture_state(host), shown_positions(target)
        bend(host)
        module("engine.update").prepare_session(host)
        module("engine.update").update_pose(host)
        self.assert_follows(host, target)
        module("pose.result").restore_state(host, bent)
        self.assert_close(shown_positions(target), shown, 1e-6)
        module("pose.result").restore_state(host, at_rest)
        self.assertEqual(key_names(target), ["Basis"])

    def test_reset_and_apply_as_rest(self):
        host, target, buckle = solved(), sleeve(), eye()
        other = own_key(target, "Puffed", 0.1, value=0.0)
        self.api.attach(host, [target])
        self.api.attach(target, [buckle])
        shown = [shown_positions(obj) for obj in (host, target, buckle)]
        self.api.apply_pose_as_rest(host)
        for obj, positions in zip((host, target, buckle), shown, strict=True):
            self.assert_close(rest_positions(obj), positions, 1e-5)
            self.assert_close(shown_positions(obj), positions, 1e-5)
        self.assert_close(key_positions(target, other.name), shown[1] + (0.1, 0.0, 0.0), 1e-5)
        bend(host)
        self.api.solve(host)
        self.assert_follows(host, target)
        self.api.reset_pose(host)
        self.assert_at_rest(target)

    def test_a_follower_that_cannot_take_the_new_rest_stops_it(self):
        host, target, buckle = solved(), sleeve(), eye()
        self.api.attach(host, [target])
        self.api.attach(target, [buckle])
        buckle.data.shape_keys.use_relative = False
        bent = [shown_positions(obj) for obj in (host, target)]
        message = "The shape keys of 'Eye' are absolute: turn on Relative in the shape keys panel"
        self.assert_error(ValueError, message, self.api.apply_pose_as_rest, host)
        for obj, positions in zip((host, target), bent, strict=True):
            self.assert_close(shown_positions(obj), positions)
            self.assertGreater(np.abs(positions - rest_positions(obj)).max(), 0.1)
        host.arap.attachments[0].is_enabled = False
        self.api.apply_pose_as_rest(host)

    def test_a_baked_animation_has_keyframes_of_its_own_and_edit_again_shows_the_pose(self):
        host, target = animated(), sleeve()
        self.api.attach(host, [target])
        for _ in range(2):  # the second bake replaces the first
            names = self.api.bake_animation(host, 1, 21, 10)
        self.assertEqual(key_names(target), key_names(host))
        for frame in (6, 11, 21):
            self.scene.frame_set(frame)
            keys = target.data.shape_keys.key_blocks
            for name in names:
                self.assertAlmostEqual(keys[name].value, host.data.shape_keys.key_blocks[name].value, places=6)
        self.assert_follows(host, target)
        fcurves = module("scene.fcurves")
        for name in names:
            path = f'key_blocks["{name}"].value'
            points = [
                [tuple(point.co) for point in fcurves.fcurves_of(obj.data.shape_keys).find(path).keyframe_points]
                for obj in (host, target)
            ]
            self.assertEqual(*points)
        module("scene.baked").edit_again(host, is_removing=True)
        self.assertEqual((key_names(target), key_names(host)), (["Basis"], ["Basis"]))

    def test_bake_pose_and_stored_poses_and_one_slider_moves_all(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        self.api.bake_pose(host, "Wave")
        self.api.store_pose(host, "Stored")
        self.api.poses_to_keys(host)
        self.assertEqual(key_names(target), ["Basis", "ARAP", "Wave", "Stored"])
        keys, own = host.data.shape_keys.key_blocks, target.data.shape_keys.key_blocks
        keys["ARAP"].mute = True
        for name in ("Wave", "Stored"):
            keys[name].value = 1.0
            self.assert_follows(host, target)
            keys[name].value = 0.0
        bpy.context.view_layer.update()
        self.assert_at_rest(target)
        keys["Wave"].value = 0.25
        bpy.context.view_layer.update()
        self.assertAlmostEqual(own["Wave"].value, 0.25, places=6)  # Blender 5.2 rounds what a driver gives
        self.assertEqual(own["ARAP"].value, 0.0)

    def test_undo_and_redo(self):
        host, target = posable(), sleeve()
        self.api.attach(host, [target])
        self.api.solve(host)
        bpy.ops.ed.undo_push(message="at rest")
        bend(host)
        self.api.solve(host)
        bent = shown_positions(target)
        bpy.ops.ed.undo_push(message="bent")
        bpy.ops.ed.undo()
        self.assert_at_rest(bpy.data.objects["Sleeve"])
        bpy.ops.ed.redo()
        self.assert_close(shown_positions(bpy.data.objects["Sleeve"]), bent, 1e-6)

    def test_a_saved_file_goes_on(self):
        host, target = solved(), sleeve()
        self.api.attach(host, [target])
        bent = shown_positions(target)
        host, target = opened_again(), bpy.data.objects["Sleeve"]
        self.assert_close(shown_positions(target), bent, 1e-6)
        bend(host)
        self.api.solve(host)
        self.assert_follows(host, target)

    def test_a_follower_may_carry_others(self):
        host, target, buckle = posable(), sleeve(), eye()
        self.api.attach(target, [buckle])
        self.api.attach(host, [target])
        bend(host)
        self.api.solve(host)
        self.assert_follows(host, target)
        self.assert_follows(target, buckle)

    def test_half_a_body_with_a_mirror_modifier_carries_on_both_sides(self):
        host = mesh_object()
        half = bmesh.new()
        half.from_mesh(host.data)
        bmesh.ops.delete(half, geom=[v for v in half.verts if v.co.x < -1e-4], context="VERTS")
        half.to_mesh(host.data)
        half.free()
        host.modifiers.new("Mirror", "MIRROR")
        target = sleeve()
        self.api.attach(host, [target])
        z = rest_positions(host)[:, 2]
        self.api.add_pin(host, np.flatnonzero(z < 0.1), name="Feet")
        top = host.arap.controls[self.api.add_handle(host, np.flatnonzero(z > 3.9), name="Head")].target
        top.location.y += 1.0
        bpy.context.view_layer.update()
        self.api.solve(host)
        rest, shown = rest_positions(target), shown_positions(target)
        flipped = [np.linalg.norm(rest - point * (-1, 1, 1), axis=1).argmin() for point in rest]
        self.assertGreater((shown - rest)[:, 1].max(), 0.3)
        self.assert_close(shown[flipped], shown * (-1, 1, 1), 2e-3)  # of vertices as near, other ones are anchors
