# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry Along: a sleeve and an eye on the tube follow however it is posed."""

import bmesh
import numpy as np
from clothes import CarryTest, eye, sleeve
from looks import edge_lengths, key_names, key_positions, rest_positions, shown_positions
from support import bpy, module, opened_again
from tubes import PLACED, animate, animated, bend, mesh_object, own_key, posable, solved


class FollowTest(CarryTest):
    """Every way of posing."""

    def test_clothes_bend_and_eyes_keep_their_shape_under_an_uneven_scale(self):
        body = posable(matrix=PLACED)
        clothes, ball = sleeve(PLACED), eye(PLACED)
        added = self.api.carry_along(body, [clothes, ball])
        self.assertEqual([follower.kind for follower in added], ["bend", "rigid"])
        bend(body)
        self.api.solve(body)
        for target in (clothes, ball):
            self.assert_goes_along(body, target)
        self.assert_close(edge_lengths(ball, shown_positions(ball)), edge_lengths(ball, rest_positions(ball)), 2e-6)

    def test_a_posed_body_takes_them_to_its_pose_at_once(self):
        body = solved()
        target = sleeve()
        self.api.carry_along(body, [target])
        self.assert_goes_along(body, target)

    def test_follow_and_playback(self):
        body, target = posable(), sleeve()
        self.api.carry_along(body, [target])
        body.arap.use_follow = True
        animate(body)
        for frame in (5, 11):
            self.scene.frame_set(frame)
            self.assert_goes_along(body, target)

    def test_what_restores_a_pose_restores_them(self):
        """Esc of Pose and of a pull."""
        body, target = posable(), sleeve()
        self.api.carry_along(body, [target])
        at_rest = module("pose.result").capture_state(body)
        bend(body)
        self.api.solve(body)
        bent, shown = module("pose.result").capture_state(body), shown_positions(target)
        bend(body)
        module("engine.update").prepare_session(body)
        module("engine.update").update_pose(body)
        self.assert_goes_along(body, target)
        module("pose.result").restore_state(body, bent)
        self.assert_close(shown_positions(target), shown, 1e-6)
        module("pose.result").restore_state(body, at_rest)
        self.assertEqual(key_names(target), ["Basis"])

    def test_reset_and_apply_as_rest(self):
        body, target, buckle = solved(), sleeve(), eye()
        other = own_key(target, "Puffed", 0.1, value=0.0)
        self.api.carry_along(body, [target])
        self.api.carry_along(target, [buckle])
        shown = [shown_positions(obj) for obj in (body, target, buckle)]
        self.api.apply_pose_as_rest(body)
        for obj, positions in zip((body, target, buckle), shown, strict=True):
            self.assert_close(rest_positions(obj), positions, 1e-5)
            self.assert_close(shown_positions(obj), positions, 1e-5)
        self.assert_close(key_positions(target, other.name), shown[1] + (0.1, 0.0, 0.0), 1e-5)
        bend(body)
        self.api.solve(body)
        self.assert_goes_along(body, target)
        self.api.reset_pose(body)
        self.assert_at_rest(target)

    def test_a_follower_that_cannot_take_the_new_rest_stops_it(self):
        body, target, buckle = solved(), sleeve(), eye()
        self.api.carry_along(body, [target])
        self.api.carry_along(target, [buckle])
        buckle.data.shape_keys.use_relative = False
        bent = [shown_positions(obj) for obj in (body, target)]
        message = "The shape keys of 'Eye' are absolute: turn on Relative in the shape keys panel"
        self.assert_error(ValueError, message, self.api.apply_pose_as_rest, body)
        for obj, positions in zip((body, target), bent, strict=True):
            self.assert_close(shown_positions(obj), positions)
            self.assertGreater(np.abs(positions - rest_positions(obj)).max(), 0.1)
        body.arap.followers[0].is_enabled = False
        self.api.apply_pose_as_rest(body)

    def test_a_baked_animation_has_keyframes_of_its_own_and_edit_again_shows_the_pose(self):
        body, target = animated(), sleeve()
        self.api.carry_along(body, [target])
        for _ in range(2):  # the second bake replaces the first
            names = self.api.bake_animation(body, 1, 21, 10)
        self.assertEqual(key_names(target), key_names(body))
        for frame in (6, 11, 21):
            self.scene.frame_set(frame)
            keys = target.data.shape_keys.key_blocks
            for name in names:
                self.assertAlmostEqual(keys[name].value, body.data.shape_keys.key_blocks[name].value, places=6)
        self.assert_goes_along(body, target)
        fcurves = module("scene.fcurves")
        for name in names:
            path = f'key_blocks["{name}"].value'
            points = [
                [tuple(point.co) for point in fcurves.fcurves_of(obj.data.shape_keys).find(path).keyframe_points]
                for obj in (body, target)
            ]
            self.assertEqual(*points)
        module("scene.baked").edit_again(body, is_removing=True)
        self.assertEqual((key_names(target), key_names(body)), (["Basis"], ["Basis"]))

    def test_bake_pose_and_stored_poses_and_one_slider_moves_all(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        self.api.bake_pose(body, "Wave")
        self.api.store_pose(body, "Stored")
        self.api.poses_to_keys(body)
        self.assertEqual(key_names(target), ["Basis", "ARAP", "Wave", "Stored"])
        keys, own = body.data.shape_keys.key_blocks, target.data.shape_keys.key_blocks
        keys["ARAP"].mute = True
        for name in ("Wave", "Stored"):
            keys[name].value = 1.0
            self.assert_goes_along(body, target)
            keys[name].value = 0.0
        bpy.context.view_layer.update()
        self.assert_at_rest(target)
        keys["Wave"].value = 0.25
        bpy.context.view_layer.update()
        self.assertAlmostEqual(own["Wave"].value, 0.25, places=6)  # Blender 5.2 rounds what a driver gives
        self.assertEqual(own["ARAP"].value, 0.0)

    def test_undo_and_redo(self):
        body, target = posable(), sleeve()
        self.api.carry_along(body, [target])
        self.api.solve(body)
        bpy.ops.ed.undo_push(message="at rest")
        bend(body)
        self.api.solve(body)
        bent = shown_positions(target)
        bpy.ops.ed.undo_push(message="bent")
        bpy.ops.ed.undo()
        self.assert_at_rest(bpy.data.objects["Sleeve"])
        bpy.ops.ed.redo()
        self.assert_close(shown_positions(bpy.data.objects["Sleeve"]), bent, 1e-6)

    def test_a_saved_file_goes_on(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        bent = shown_positions(target)
        body, target = opened_again(), bpy.data.objects["Sleeve"]
        self.assert_close(shown_positions(target), bent, 1e-6)
        bend(body)
        self.api.solve(body)
        self.assert_goes_along(body, target)

    def test_a_follower_may_carry_others(self):
        body, target, buckle = posable(), sleeve(), eye()
        self.api.carry_along(target, [buckle])
        self.api.carry_along(body, [target])
        bend(body)
        self.api.solve(body)
        self.assert_goes_along(body, target)
        self.assert_goes_along(target, buckle)

    def test_half_a_body_with_a_mirror_modifier_carries_on_both_sides(self):
        body = mesh_object()
        half = bmesh.new()
        half.from_mesh(body.data)
        bmesh.ops.delete(half, geom=[v for v in half.verts if v.co.x < -1e-4], context="VERTS")
        half.to_mesh(body.data)
        half.free()
        body.modifiers.new("Mirror", "MIRROR")
        target = sleeve()
        self.api.carry_along(body, [target])
        z = rest_positions(body)[:, 2]
        self.api.add_pin(body, np.flatnonzero(z < 0.1), name="Feet")
        top = body.arap.controls[self.api.add_handle(body, np.flatnonzero(z > 3.9), name="Head")].target
        top.location.y += 1.0
        bpy.context.view_layer.update()
        self.api.solve(body)
        rest, shown = rest_positions(target), shown_positions(target)
        flipped = [np.linalg.norm(rest - point * (-1, 1, 1), axis=1).argmin() for point in rest]
        self.assertGreater((shown - rest)[:, 1].max(), 0.3)
        self.assert_close(shown[flipped], shown * (-1, 1, 1), 2e-3)  # of vertices as near, other ones are anchors
