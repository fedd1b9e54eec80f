# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes of a pose: a key of its own, the new rest shape, nothing; and the way back on Esc."""

import numpy as np
from looks import key_positions, rest_positions, shown_positions
from support import SceneTest, bpy, module
from tubes import MIDDLE, SEGMENTS, TOP, armature, bend, empty_at, move, own_key, posable, solved


def held_shapes(obj):
    """What pins and handles hold, by name."""
    entries = (*obj.arap.pins, *obj.arap.handles)
    return {
        entry.name: (entry.base_id, *(array.tolist() for array in entry.base), getattr(entry, "reach", 0.0))
        for entry in entries
    }


class ResultTest(SceneTest):
    def test_bake_pose_keeps_a_copy_at_value_zero(self):
        obj = solved()
        posed = key_positions(obj)
        key = self.api.bake_pose(obj, name="Wave")
        self.assertEqual((key.name, key.value), ("Wave", 0.0))
        self.assert_close(key_positions(obj, "Wave"), posed, 0.0)
        self.assertEqual(self.api.bake_pose(obj, name="Wave").name, "Wave.001")
        self.api.reset_handles(obj)
        self.api.solve(obj)
        self.assert_close(key_positions(obj, "Wave"), posed, 0.0)
        self.assert_error(
            ValueError, "The baked pose needs a name: type one, for example Pose", self.api.bake_pose, obj, ""
        )

    def test_what_becomes_of_a_pose_is_what_is_shown(self):
        obj = solved()
        rest, posed = rest_positions(obj), key_positions(obj)
        key = obj.data.shape_keys.key_blocks["ARAP"]
        key.mute = True
        message = (
            "Shape key 'ARAP' of 'Tube' is muted, so the pose would not show: "
            "press Edit Again after a bake, else unmute it"
        )
        for function in (self.api.bake_pose, self.api.apply_pose_as_rest):
            self.assert_error(ValueError, message, function, obj)
        key.mute = False
        key.value = 0.5
        half = rest + 0.5 * (posed - rest)
        on_pose = obj.shape_key_add(name="On pose")
        on_pose.value = 0.0
        on_pose.relative_key = key
        for point, place in zip(on_pose.data, posed, strict=True):
            point.co = place
            point.co.y += 0.5
        self.api.bake_pose(obj, name="Half")
        self.assert_close(key_positions(obj, "Half"), half, 1e-6)
        self.assert_close(shown_positions(obj), half, 1e-6)
        self.api.apply_pose_as_rest(obj)
        self.assert_close(key_positions(obj, "Basis"), half, 1e-6)
        self.assert_close(key_positions(obj), half, 1e-6)
        self.assert_close(shown_positions(obj), half, 1e-6)
        self.assert_close(key_positions(obj, "On pose"), half + np.array([0.0, 0.5, 0.0]), 1e-5)

    def test_what_needs_a_pose_says_so(self):
        obj = posable()
        message = "'Tube' has no pose yet: pose it first"
        self.assert_error(ValueError, message, self.api.bake_pose, obj)
        self.assert_error(ValueError, message, self.api.apply_pose_as_rest, obj)
        self.api.reset_pose(obj)
        self.assertIsNone(obj.data.shape_keys)

    def test_reset_pose_goes_back_to_rest_and_leaves_the_handles(self):
        obj = solved()
        place = obj.arap.handles[0].target.matrix_world.copy()
        self.api.reset_pose(obj)
        self.assert_close(key_positions(obj), rest_positions(obj), 0.0)
        self.assertEqual(obj.arap.handles[0].target.matrix_world, place)
        self.assert_close(module("engine.update").prepare_session(obj).positions, rest_positions(obj), 1e-6)

    def test_apply_pose_as_rest(self):
        obj = posable()
        own_key(obj, "Smile", value=0.0)
        bend(obj)
        self.api.solve(obj)
        posed = key_positions(obj)
        shown = shown_positions(obj)
        self.api.apply_pose_as_rest(obj)
        self.assert_close(key_positions(obj, "Basis"), posed, 0.0)
        self.assert_close(key_positions(obj), posed, 0.0)
        self.assert_close(key_positions(obj, "Smile"), posed + np.array([0.25, 0.0, 0.0]), 1e-5)
        self.assert_close(shown_positions(obj), shown, 1e-5)
        self.assert_close(module("scene.versions").read_positions(obj.data), posed, 0.0)
        self.assert_close(module("scene.handle_motion").handle_matrices(obj), np.tile(np.eye(4), (2, 1, 1)), 1e-6)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), posed, 4e-6)
        self.api.reset_handles(obj)
        self.assert_close(module("scene.handle_motion").handle_matrices(obj), np.tile(np.eye(4), (2, 1, 1)), 1e-5)

    def test_state_brings_back_key_slider_and_handles(self):
        obj = solved()
        key = obj.data.shape_keys.key_blocks["ARAP"]
        key.slider_max = 0.5
        key.value = 0.4
        target = obj.arap.handles[0].target
        parent = bpy.data.objects.new("Parent", None)
        self.scene.collection.objects.link(parent)
        target.parent = parent
        state = module("pose.result").capture_state(obj)
        before = key_positions(obj), target.matrix_basis.copy(), parent.matrix_basis.copy()
        move(target, (1.0, 1.0, 1.0), (0.3, 0.2, 0.1))
        parent.location = (1.0, 2.0, 3.0)
        bpy.context.view_layer.update()
        self.api.solve(obj)
        module("pose.result").restore_state(obj, state)
        self.assert_close(key_positions(obj), before[0], 0.0)
        self.assertAlmostEqual(key.value, 0.4, places=6)
        self.assertEqual(key.slider_max, 0.5)
        self.assertEqual((target.matrix_basis, parent.matrix_basis), before[1:])
        self.assert_close(module("engine.update").prepare_session(obj).positions, before[0], 1e-6)

    def test_state_brings_back_what_constraints_name(self):
        obj = posable()
        followed = empty_at((0.0, 0.0, 4.0), "Followed")
        rig = armature()
        obj.arap.handles[0].target.constraints.new("COPY_ROTATION").target = followed
        held = obj.arap.handles[0].target.constraints.new("ARMATURE").targets.new()  # it has several
        held.target, held.subtarget = rig, "Lower"
        state = module("pose.result").capture_state(obj)
        bone = rig.pose.bones["Lower"]
        followed.location.x = bone.location.x = 1.0
        module("pose.result").restore_state(obj, state)
        self.assertEqual((followed.location.x, bone.location.x), (0.0, 0.0))

    def test_state_brings_back_what_pins_and_handles_hold(self):
        """Reset Handles and Add Pin change that while the mesh is posed."""

        obj = posable()
        obj.arap.rigidity = 12.0  # so that the patch of Spot reaches its neighbors
        bend(obj)
        self.api.solve(obj)
        self.api.add_handle(obj, MIDDLE[:1], name="Spot")
        self.api.add_pin(obj, [TOP[0] - SEGMENTS], name="Held")
        before = held_shapes(obj)
        self.assertNotEqual(before["Held"][1], 0)
        state = module("pose.result").capture_state(obj)
        self.api.add_pin(obj, [MIDDLE[1]], name="New")
        self.assertNotEqual(held_shapes(obj)["Spot"], before["Spot"])
        self.api.remove_control(obj, obj.arap.pins[2].name)
        self.api.reset_handles(obj)
        module("pose.result").restore_state(obj, state)
        self.assertEqual(held_shapes(obj), before)

    def test_what_is_added_before_esc_holds_the_mesh_as_it_was(self):
        obj = solved()
        shown = key_positions(obj)
        state = module("pose.result").capture_state(obj)
        move(obj.arap.handles[0].target, (0.0, -1.0, 0.5))
        self.api.solve(obj)
        self.api.add_pin(obj, [MIDDLE[1]], name="New")
        self.api.add_handle(obj, [MIDDLE[4] + SEGMENTS], name="New")
        module("pose.result").restore_state(obj, state)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), shown, 1e-4)

    def test_a_handle_with_another_object_is_one_that_was_added(self):
        obj = solved()
        shown = key_positions(obj)
        state = module("pose.result").capture_state(obj)
        move(obj.arap.handles[0].target, (0.0, -1.0, 0.5))
        self.api.solve(obj)
        obj.arap.handles[0].target = empty_at((2.0, 0.0, 0.0))
        module("pose.result").restore_state(obj, state)
        self.api.solve(obj)
        self.assert_close(key_positions(obj), shown, 1e-4)

    def test_state_without_a_key_leaves_none(self):
        for has_keys in (False, True):
            obj = posable(f"Tube{has_keys}")
            rest = rest_positions(obj)
            if has_keys:
                obj.shape_key_add(name="Basis")
            state = module("pose.result").capture_state(obj)
            bend(obj)
            self.api.solve(obj)
            module("pose.result").restore_state(obj, state)
            keys = obj.data.shape_keys
            self.assertEqual([key.name for key in keys.key_blocks] if keys else None, ["Basis"] if has_keys else None)
            self.assert_close(shown_positions(obj), rest, 1e-6)

    def test_state_brings_back_the_active_key(self):
        obj = posable()
        for name in ("Basis", "Smile", "Frown"):
            obj.shape_key_add(name=name).value = 0.0
        for name in ("Smile", "Frown"):
            obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find(name)
            for _ in range(2):  # without the pose key, then with it
                state = module("pose.result").capture_state(obj)
                self.api.solve(obj)
                obj.active_shape_key_index = obj.data.shape_keys.key_blocks.find("ARAP")
                module("pose.result").restore_state(obj, state)
                self.assertEqual(obj.active_shape_key.name, name)
                self.api.solve(obj)
            module("scene.shape_keys").remove(obj, "ARAP")
            self.assertEqual(obj.active_shape_key.name, name)

    def test_state_of_another_mesh_is_refused_but_the_handles_go_back(self):
        obj = posable()
        self.api.solve(obj)
        state = module("pose.result").capture_state(obj)
        target = obj.arap.handles[0].target
        before = target.matrix_basis.copy()
        bend(obj)
        obj.shape_key_clear()
        obj.data.clear_geometry()
        message = "'Tube' has 0 vertices, but had 136: its shape key stays"
        self.assert_error(ValueError, message, module("pose.result").restore_state, obj, state)
        self.assertEqual(target.matrix_basis, before)

    def test_state_passes_over_what_is_gone(self):
        obj = posable()
        state = module("pose.result").capture_state(obj)
        bpy.data.objects.remove(obj.arap.handles[0].target)
        module("pose.result").restore_state(obj, state)
