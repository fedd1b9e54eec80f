# SPDX-License-Identifier: GPL-3.0-or-later
"""Stored poses as shape keys: solved to the end, named, and nobody else's key touched."""

from looks import data_of, key_names, key_positions, rest_positions
from modifiers import add_nodes
from support import SceneTest, bpy, module
from tubes import BOTTOM, MIDDLE, armature, bend, mesh_object, move, posable


class PoseKeysTest(SceneTest):
    def with_poses(self):
        """Poses Bent and Turned, and what Solve makes of each; the handles are elsewhere then."""
        obj = posable()
        truth = {}
        bend(obj)
        for name in ("Bent", "Turned"):
            self.api.solve(obj)
            truth[name] = key_positions(obj)
            self.api.store_pose(obj, name)
            move(obj.arap.handles[0].target, (0.5, -0.5, 0.0), (0.0, 0.7, 0.4))
        obj.shape_key_clear()
        return obj, truth

    def test_each_pose_is_a_key_as_solve_makes_it(self):
        obj, truth = self.with_poses()
        handles = module("scene.handle_motion").handle_matrices(obj)
        self.assertEqual(self.api.poses_to_keys(obj), ["Bent", "Turned"])
        self.assertEqual(key_names(obj), ["Basis", "Bent", "Turned"])
        for name, shape in truth.items():
            self.assert_close(key_positions(obj, name), shape, 1e-5)
            self.assertEqual(obj.data.shape_keys.key_blocks[name].value, 0.0)
        self.assert_close(module("scene.handle_motion").handle_matrices(obj), handles, 0.0)

    def test_some_of_them(self):
        obj, truth = self.with_poses()
        self.assertEqual(self.api.poses_to_keys(obj, ["Turned"]), ["Turned"])
        self.assert_close(key_positions(obj, "Turned"), truth["Turned"], 1e-5)

    def test_again_renews_the_same_keys(self):
        obj, _ = self.with_poses()
        self.api.poses_to_keys(obj)
        keys = obj.data.shape_keys.key_blocks
        keys["Bent"].value = 0.75
        self.api.solve(obj)
        self.api.store_pose(obj, "Bent", replace=True)
        self.assertEqual(self.api.poses_to_keys(obj), ["Bent", "Turned"])
        self.assertEqual(key_names(obj), ["Basis", "Bent", "Turned", "ARAP"])
        self.assertEqual(keys["Bent"].value, 0.75)
        self.assert_close(key_positions(obj, "Bent"), key_positions(obj), 1e-4)

    def test_a_renamed_pose_renames_its_key(self):
        obj, _ = self.with_poses()
        self.api.poses_to_keys(obj)
        obj.arap.poses[0].name = "Bow"
        self.assertEqual(self.api.poses_to_keys(obj), ["Bow", "Turned"])
        self.assertEqual(key_names(obj), ["Basis", "Bow", "Turned"])

    def test_what_moves_the_handles_does_not_matter_but_whether_a_key_is_seen(self):
        obj, rig = mesh_object(), armature()
        self.api.add_pin(obj, BOTTOM)
        self.api.add_handle_for(obj, rig, "Upper", 0.7)
        self.api.store_pose(obj, "Bent")
        rig.data.pose_position = "REST"
        self.assertEqual(self.api.poses_to_keys(obj), ["Bent"])
        obj.show_only_shape_key, obj.active_shape_key_index = True, 1
        modifier = add_nodes(obj, takes_places=False)
        self.assertEqual(self.api.poses_to_keys(obj), ["Bent"])
        obj.modifiers.remove(modifier)
        add_nodes(obj, takes_places=True)
        message = (
            "A pose of 'Tube' would not be seen: modifier 'Nodes' takes the vertices from elsewhere; switch it off in "
            "viewports and renders"
        )
        self.assert_error(ValueError, message, self.api.poses_to_keys, obj)

    def test_keys_of_others_are_left_alone(self):
        obj, truth = self.with_poses()
        obj.shape_key_add(name="Basis")
        mine = obj.shape_key_add(name="Bent")
        mine.data[3].co.x += 0.5
        before = key_positions(obj, "Bent")
        for _ in range(2):
            self.assertEqual(self.api.poses_to_keys(obj), ["Bent.001", "Turned"])
            self.assert_close(key_positions(obj, "Bent"), before, 0.0)
            self.assert_close(key_positions(obj, "Bent.001"), truth["Bent"], 1e-5)
        self.assertEqual(key_names(obj), ["Basis", "Bent", "Bent.001", "Turned"])

    def test_a_key_that_somebody_has_changed_is_his(self):
        obj, truth = self.with_poses()
        self.api.poses_to_keys(obj)
        obj.data.shape_keys.key_blocks["Bent"].data[5].co.z += 0.25
        sculpted = key_positions(obj, "Bent")
        self.assertEqual(self.api.poses_to_keys(obj), ["Bent.001", "Turned"])
        self.assert_close(key_positions(obj, "Bent"), sculpted, 0.0)
        self.assert_close(key_positions(obj, "Bent.001"), truth["Bent"], 1e-5)

    def test_the_reference_key_is_never_written(self):
        """Not even where somebody has made a pose's key the first one."""
        obj, _ = self.with_poses()
        self.api.poses_to_keys(obj)
        obj.arap.poses[0].key_name = "Basis"
        rest = rest_positions(obj)
        self.assertEqual(self.api.poses_to_keys(obj), ["Bent.001", "Turned"])
        self.assert_close(rest_positions(obj), rest, 0.0)

    def test_the_pose_key_and_the_active_key_stay(self):
        obj, _ = self.with_poses()
        self.api.solve(obj)
        live = key_positions(obj)
        self.api.store_pose(obj, "ARAP")
        for active in ("ARAP", "Basis"):
            obj.active_shape_key_index = key_names(obj).index(active)
            self.assertEqual(self.api.poses_to_keys(obj), ["Bent", "Turned", "ARAP.001"])
            self.assertEqual(obj.active_shape_key.name, active)
        self.assert_close(key_positions(obj), live, 0.0)
        self.assertEqual(obj.data.shape_keys.key_blocks["ARAP"].value, 1.0)

    def test_a_pose_with_the_pose_keys_name_is_not_taken_for_it(self):
        obj, _ = self.with_poses()
        self.api.store_pose(obj, "ARAP")
        self.api.poses_to_keys(obj, ["ARAP"])
        before = key_positions(obj, "ARAP")
        bend(obj)
        self.api.solve(obj)
        self.assert_close(key_positions(obj, "ARAP"), before, 0.0)
        self.assertEqual(obj.arap.key_name, "ARAP.001")

    def test_handles_that_a_pose_does_not_know_are_at_rest(self):
        obj, _ = self.with_poses()
        waist = obj.arap.controls[self.api.add_handle(obj, MIDDLE, name="Waist")]
        first = self.api.poses_to_keys(obj, ["Bent"])
        shape = key_positions(obj, *first)
        self.assert_close(shape[MIDDLE], rest_positions(obj)[MIDDLE], 1e-5)
        move(waist.target, (1.0, 0.0, 0.0))
        self.api.poses_to_keys(obj, ["Bent"])
        self.assert_close(key_positions(obj, *first), shape, 0.0)

    def test_a_cancel_leaves_nothing(self):
        obj, _ = self.with_poses()
        self.api.solve(obj)
        session = module("engine.update").prepare_session(obj)
        positions = session.positions.copy()
        before = data_of(obj)
        message = "The making of shape keys of 'Tube' was cancelled; nothing has changed"
        self.assert_error(self.api.Cancelled, message, self.api.poses_to_keys, obj, None, lambda done: done < 0.5)
        self.assertEqual(data_of(obj), before)
        self.assert_close(session.positions, positions, 0.0)
        self.api.poses_to_keys(obj)
        self.assert_close(session.positions, positions, 0.0)

    def test_refusals(self):
        obj = posable()
        other = bpy.data.scenes.new("Other")
        for message, arguments in (
            ("'Tube' has no stored poses: store one first", {}),
            ("'Tube' has no stored pose 'Smile': choose one of the list", {"names": ["Smile"]}),
            ("'Tube' is not in scene 'Other': choose one of its objects", {"scene": other}),
        ):
            self.assert_error(ValueError, message, self.api.poses_to_keys, obj, **arguments)
        self.api.store_pose(obj)
        job = module("poses.keys").PoseKeysJob(obj)
        self.api.delete_pose(obj, "Pose")
        while job.step():
            pass
        self.assert_error(ValueError, "'Tube' has no stored pose 'Pose': choose one of the list", job.finish)
        job.cancel()
        self.assertEqual(key_names(obj), [])
