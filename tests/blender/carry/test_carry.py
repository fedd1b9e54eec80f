# SPDX-License-Identifier: GPL-3.0-or-later
"""Carry Along: a sleeve and an eye on the tube follow however it is posed."""

import bmesh
import numpy as np
from clothes import CarryTest, eye, new_object, sleeve
from looks import edge_lengths, in_world, key_names, key_positions, rest_positions, shown_positions
from support import bpy, linked_back, module, opened_again
from tubes import PLACED, Matrix, animate, animated, bend, mesh_object, own_key, posable, solved


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

    def test_followers_share_what_is_prepared_of_the_body_and_let_it_go(self):
        body, targets = posable(), [sleeve(), eye(), sleeve(name="Cuff")]
        self.api.carry_along(body, targets)
        bend(body)
        self.api.solve(body)
        wraps = module("carry.wraps")
        self.assertEqual(len({id(wraps._bound[target.name]._surface) for target in targets}), 1)
        self.assertIsNone(wraps._prepared._kept)

    def test_follow_playback_and_cancel(self):
        body, target = posable(), sleeve()
        self.api.carry_along(body, [target])
        body.arap.is_live = True
        animate(body)
        for frame in (5, 11):
            self.scene.frame_set(frame)
            self.assert_goes_along(body, target)
        module("pose.starts").end_following(body, is_kept=False)
        self.scene.frame_set(1)
        self.assert_at_rest(target)
        self.assertEqual(key_names(target), ["Basis"])

    def test_what_restores_a_pose_restores_them(self):
        """Esc of Pose and of a pull."""
        body, target = posable(), sleeve()
        self.api.carry_along(body, [target])
        at_rest = module("pose.result").capture_state(body)
        bend(body)
        self.api.solve(body)
        bent, shown = module("pose.result").capture_state(body), shown_positions(target)
        bend(body)
        module("follow.update").prepare_session(body)
        module("follow.update").update_pose(body)
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

    def test_what_ends_a_bind_in_the_background_switches_the_follower_off(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        wraps, follower = module("carry.wraps"), body.arap.followers[0]
        wraps.forget("Sleeve")
        wraps.begin(body, follower)
        binding = wraps._binding["Sleeve"]
        if wraps.is_binding("Sleeve"):  # it may have ended
            self.assertTrue(binding.wait().text.startswith("Preparing Sleeve, "))
        text = "Preparing 'Sleeve' cancelled: it does not go along until it is ticked in the list"
        self.assertEqual(binding.give_up(), text)
        self.assertEqual((follower.is_enabled, wraps.is_any_binding()), (False, False))
        self.assert_at_rest(target)
        follower.is_enabled = True
        self.assert_goes_along(body, target)

    def test_who_needs_a_bind_that_is_under_way_waits_for_it(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        wraps, follower = module("carry.wraps"), body.arap.followers[0]
        for is_edited in (False, True):
            wraps.forget("Sleeve")
            wraps.begin(body, follower)
            begun = wraps._binding["Sleeve"].work
            if is_edited:
                module("scene.versions").write_key(target.data.shape_keys.reference_key, rest_positions(target) * 1.1)
                wraps.suspect("Sleeve")
            self.assertIs(wraps.bound(body, follower) is begun.result(), not is_edited)
            self.assertFalse(wraps.is_any_binding())

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
        top = self.api.add_handle(body, np.flatnonzero(z > 3.9), name="Head").target
        top.location.y += 1.0
        bpy.context.view_layer.update()
        self.api.solve(body)
        rest, shown = rest_positions(target), shown_positions(target)
        flipped = [np.linalg.norm(rest - point * (-1, 1, 1), axis=1).argmin() for point in rest]
        self.assertGreater((shown - rest)[:, 1].max(), 0.3)
        self.assert_close(shown[flipped], shown * (-1, 1, 1), 2e-3)  # of vertices as near, other ones are anchors


class ListTest(CarryTest):
    """Who may follow whom, and what is told if one cannot."""

    def test_remove_and_the_tick_take_back_what_was_made(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        body.arap.followers[0].is_enabled = False
        self.assertEqual(key_names(target), ["Basis"])
        self.assert_at_rest(target)
        body.arap.followers[0].is_enabled = True
        self.assert_goes_along(body, target)
        self.api.stop_carrying(body, target)
        self.assertEqual((key_names(target), len(body.arap.followers)), ([], 0))
        self.assert_error(ValueError, "'Sleeve' does not go along with 'Tube'", self.api.stop_carrying, body, target)

    def test_keys_of_its_own_stay(self):
        body, target = solved(), sleeve()
        own_key(target, "ARAP", 0.5, value=1.0)
        self.api.carry_along(body, [target])
        self.assertEqual(key_names(target), ["Basis", "ARAP", "ARAP.001"])
        target.data.shape_keys.key_blocks["ARAP.001"].name = "Renamed"
        bend(body)
        self.api.solve(body)
        self.assertEqual(key_names(target), ["Basis", "ARAP", "Renamed"])
        self.assert_close(key_positions(target), rest_positions(target) + np.array([0.5, 0.0, 0.0]))
        self.api.stop_carrying(body, target)
        self.assertEqual(key_names(target), ["Basis", "ARAP"])

    def test_a_twin_that_became_the_reference_key_is_not_written(self):
        """The artist has removed Basis. What was shown is the rest shape now."""
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        target.shape_key_remove(target.data.shape_keys.reference_key)
        rest = rest_positions(target)
        self.api.solve(body)
        self.assert_close(rest_positions(target), rest, 0.0)
        self.assertEqual(key_names(target), ["ARAP", "ARAP.001"])
        self.assert_goes_along(body, target)

    def test_another_kind_counts_at_once(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        bent = shown_positions(target)
        body.arap.followers[0].kind = "rigid"
        self.assertGreater(np.abs(shown_positions(target) - bent).max(), 0.05)
        self.assert_close(edge_lengths(target, shown_positions(target)), edge_lengths(target, rest_positions(target)))

    def test_again_its_present_place_counts(self):
        body, target = solved(), eye()
        self.api.carry_along(body, [target])
        before = shown_positions(target)
        target.location.z = 0.2
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(target), before)
        self.api.carry_along(body, [target])
        self.assertEqual(len(body.arap.followers), 1)
        self.assertGreater(np.abs(shown_positions(target) - before).max(), 0.1)
        self.assert_close(shown_positions(target), self.carried(body, target), 1e-5)

    def test_who_cannot_go_along_is_told(self):
        body, target = posable(), sleeve()
        text = new_object("Label", bpy.data.curves.new("Label", "FONT"))
        hair = new_object("Hair", bpy.data.hair_curves.new("Hair"))
        hidden = sleeve(name="Elsewhere")
        self.scene.collection.objects.unlink(hidden)
        bpy.context.view_layer.update()
        other = mesh_object("Other")
        self.api.carry_along(other, [body])
        shared = new_object("Twin", target.data)
        cage = self.api.make_cage(body).target
        cases = (
            (body, "'Tube' cannot go along with 'Tube': it is the mesh itself"),
            (
                text,
                "'Label' cannot go along with 'Tube': convert it to a mesh first (Object > Convert)",
            ),
            (
                hair,
                (
                    "'Hair' cannot go along with 'Tube': hair curves follow the surface that they grow on by "
                    "themselves (Deform Curves on Surface)"
                ),
            ),
            (
                body.arap.handles[0].target,
                "'Head' cannot go along with 'Tube': it is neither a mesh nor a curve",
            ),
            (cage, f"'{cage.name}' cannot go along with 'Tube': it is one of its handles"),
            (
                hidden,
                (
                    "'Elsewhere' cannot go along with 'Tube': it is disabled in viewports or not in this view layer, "
                    "so its place is not known; enable it, or hide it with the eye"
                ),
            ),
            (other, "'Other' cannot go along with 'Tube', which goes along with it: that would be a circle"),
            (
                shared,
                (
                    "The mesh of 'Twin' is shared with other objects, which would deform too: make it single-user "
                    "(Object > Relations > Make Single User > Object & Data)"
                ),
            ),
        )
        for obj, message in cases:
            self.assert_error(ValueError, message, self.api.carry_along, body, [eye(), obj])
            self.assertEqual(len(body.arap.followers), 0, "all or none")
        bpy.data.objects.remove(shared)
        self.api.carry_along(other, [target])
        message = (
            "'Sleeve' cannot go along with 'Tube': it goes along with 'Other' already; remove it from the list there "
            "first"
        )
        self.assert_error(ValueError, message, self.api.carry_along, body, [target])
        message = "kind = 'soft', must be 'bend' or 'rigid', or '' for the one that fits"
        self.assert_error(ValueError, message, self.api.carry_along, body, [eye()], "soft")

    def test_what_goes_wrong_later_is_told_and_the_body_goes_on(self):
        body, target = posable(), sleeve()
        self.api.carry_along(body, [target])
        bpy.context.view_layer.objects.active = target
        bpy.ops.object.mode_set(mode="EDIT")
        self.assertEqual(self.problem(body), "'Sleeve' is in Edit Mode: it goes along again in Object Mode")
        bend(body)
        self.api.solve(body)
        self.assertGreater(np.abs(shown_positions(body) - rest_positions(body)).max(), 0.5)
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.update()
        self.assertEqual(self.problem(body), "")
        self.assert_goes_along(body, target)
        target.data.shape_keys.use_relative = False
        self.assertEqual(
            self.problem(body), "The shape keys of 'Sleeve' are absolute: turn on Relative in the shape keys panel"
        )
        target.data.shape_keys.use_relative = True
        target.show_only_shape_key = True
        self.assertEqual(
            self.problem(body), "'Sleeve' shows another shape key alone: turn off Shape Key Lock (the pin icon)"
        )
        target.show_only_shape_key = False
        target.shape_key_clear()
        self.api.solve(body)
        self.assertEqual(self.problem(body), "'Sleeve' has lost its shape keys: press Carry Along again")
        self.api.carry_along(body, [target])
        self.assert_goes_along(body, target)
        self.scene.collection.objects.unlink(target)
        self.assertEqual(self.problem(body), "'Sleeve' is in no scene: bring it back, or remove it from the list")
        bpy.data.objects.remove(target)
        self.assertEqual(self.problem(body), "The object is in no scene: bring it back, or remove it from the list")
        self.api.solve(body)
        module("carry.lists").remove_at(body, 0)
        self.assertEqual(len(body.arap.followers), 0)

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

    def test_a_key_that_the_artist_removes_takes_its_twin_along(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        body.shape_key_remove(body.data.shape_keys.key_blocks["ARAP"])
        bpy.context.view_layer.update()
        self.assertEqual(key_names(target), ["Basis"])
        self.api.solve(body)
        body.shape_key_clear()
        bpy.context.view_layer.update()
        self.assertEqual(key_names(target), ["Basis"])

    def test_a_key_that_the_artist_renames_keeps_its_twin(self):
        """As of any key that the artist has made his own, the add-on writes neither any more."""
        body, target, buckle = solved(), sleeve(), eye()
        self.api.carry_along(body, [target])
        self.api.carry_along(target, [buckle])
        self.api.bake_pose(body, "Wave")
        keys, shown = body.data.shape_keys.key_blocks, shown_positions(target)
        keys["ARAP"].name = "Kept"
        keys["Wave"].name = "Hello"
        bpy.context.view_layer.update()
        for obj in (target, buckle):
            self.assertEqual(key_names(obj), ["Basis", "Kept", "Hello"])
        self.assert_close(shown_positions(target), shown, 1e-6)
        keys["Kept"].value, keys["Hello"].value = 0.0, 1.0
        bpy.context.view_layer.update()
        self.assert_close(shown_positions(target), shown, 1e-6)
        self.api.solve(body)
        for obj in (target, buckle):
            self.assertEqual(key_names(obj), ["Basis", "Kept", "Hello", "ARAP"])
        self.api.stop_carrying(body, target)
        self.assertEqual(key_names(target), ["Basis", "Kept", "Hello"])

    def test_a_fault_stops_nothing(self):
        body, target = solved(), sleeve()
        self.api.carry_along(body, [target])
        wrap = module("carry.wraps").get(body, body.arap.followers[0])

        def fails(_positions):
            raise MemoryError

        wrap.carried = fails
        bend(body)
        self.api.solve(body)
        self.assertEqual(self.problem(body), "There is not enough memory")
        self.assertGreater(np.abs(shown_positions(body) - rest_positions(body)).max(), 0.5)
        del wrap.carried
        self.api.solve(body)
        self.assertEqual(self.problem(body), "")
        self.assert_goes_along(body, target)

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
        self.assertEqual(module("carry.wraps").names(), [])

    def test_a_linked_follower_is_told(self):
        (target,) = linked_back(sleeve(), "Sleeve")
        self.scene = bpy.context.scene
        self.scene.collection.objects.link(target)
        body = posable()
        bpy.context.view_layer.update()
        self.assert_error(
            ValueError,
            "'Sleeve' is linked from another file: make it local (Object > Relations > Make Local)",
            self.api.carry_along,
            body,
            [target],
        )

    def test_a_hidden_follower_is_written_too(self):
        """In a window a little later; without one, at once."""
        body, target = posable(), sleeve()
        self.api.carry_along(body, [target])
        target.hide_set(True)
        bend(body)
        self.api.solve(body)
        target.hide_set(False)
        self.assert_goes_along(body, target)


class OperatorTest(CarryTest):
    def select(self, body, *others):
        for obj in bpy.context.view_layer.objects:
            obj.select_set(obj in (body, *others))
        bpy.context.view_layer.objects.active = body

    def test_the_selected_objects_go_along_with_the_active_one(self):
        body, target = posable(), sleeve()
        self.select(body)
        self.assertFalse(bpy.ops.arap.carry_along.poll())
        why = module("carry.operators").why_nothing_selected
        self.assertEqual(
            why(bpy.context), "Select clothes, hair or eyes, then Shift-click the mesh that they go along with"
        )
        self.select(body, target, body.arap.handles[0].target)
        self.assertEqual(bpy.ops.arap.carry_along(), {"FINISHED"})
        self.assertEqual([follower.target for follower in body.arap.followers], [target])
        self.assertEqual(bpy.ops.arap.carry_remove(), {"FINISHED"})
        self.assertEqual(
            module("carry.operators").why_no_follower(bpy.context), "Nothing goes along yet: the list is empty"
        )

    def test_children_and_what_is_near_are_found(self):
        body, clothes, ball = posable(), sleeve(), eye()
        hat = new_object("Hat", eye().data.copy(), Matrix.Translation((0.0, 0.0, 9.0)))
        hat.parent = body
        bpy.data.objects.remove(bpy.data.objects["Eye.001"])
        button = new_object("Button", ball.data.copy(), ball.matrix_world)
        button.arap.carried.body = body  # as a copy of a follower has it
        new_object("Far", hat.data.copy(), Matrix.Translation((3.0, 0.0, 2.0)))
        nowhere = new_object("Nowhere", ball.data.copy(), ball.matrix_world)
        nowhere.data.vertices[1].co.x = np.nan
        floor = bpy.data.meshes.new("Floor")
        floor.from_pydata([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)], [], [(0, 1, 2, 3)])
        new_object("Floor", floor)
        self.select(body)
        bpy.context.view_layer.update()
        self.assertEqual(bpy.ops.arap.carry_near(), {"FINISHED"})
        self.assertEqual({follower.target for follower in body.arap.followers}, {clothes, ball, hat, button})
        found = [follower.target for follower in body.arap.followers]
        text = module("carry.operators").added_text(body, found)
        self.assertRegex(text, r"^Along with 'Tube': 4 objects \(\w+, \w+, \w+ and 1 more\)$")
        with self.assertRaisesRegex(RuntimeError, "No other mesh is near 'Tube'"):
            bpy.ops.arap.carry_near()
