# SPDX-License-Identifier: GPL-3.0-or-later
"""Which key takes the pose, and what happens to keys of the artist."""

import support
from looks import key_names, key_positions, rest_positions
from support import SceneTest, bpy, module, opened_again
from tubes import bend, copied, own_key, posable


class PoseKeyTest(SceneTest):
    """The key of the pose is one that was made for it; a key of the artist's own that has its name is not."""

    def test_a_key_that_has_the_name_already_is_left_alone(self):
        obj = posable()
        own_key(obj, "ARAP", value=0.5)
        mine = key_positions(obj)
        bend(obj)
        for _ in range(2):
            self.api.solve(obj)
            self.assertEqual(key_names(obj), ["Basis", "ARAP", "ARAP.001"])
            self.assertEqual(obj.arap.key_name, "ARAP.001")
        module("engine.update").prepare_session(obj)
        module("engine.update").update_pose(obj)
        self.assertEqual(self.api.bake_pose(obj, "Bent").name, "Bent")
        self.assert_close(key_positions(obj, "Bent"), key_positions(obj, "ARAP.001"), 0.0)
        self.api.reset_pose(obj)
        self.assert_close(key_positions(obj, "ARAP.001"), rest_positions(obj), 0.0)
        self.api.bake_animation(obj, 1, 2)
        keys = obj.data.shape_keys.key_blocks
        self.assertEqual((keys["ARAP"].mute, keys["ARAP.001"].mute), (False, True))
        self.assert_close(key_positions(obj, "ARAP"), mine, 0.0)
        self.assertEqual(keys["ARAP"].value, 0.5)

    def test_it_is_no_pose_either(self):
        obj = posable()
        own_key(obj, "ARAP")
        for function in (self.api.bake_pose, self.api.apply_pose_as_rest):
            self.assert_error(ValueError, "'Tube' has no pose yet: pose it first", function, obj)
        mine = key_positions(obj)
        self.api.reset_pose(obj)
        self.assert_close(key_positions(obj), mine, 0.0)
        target = obj.arap.controls[self.api.add_handle(obj, [40], name="More")].target
        self.assert_close(target.matrix_world.translation, rest_positions(obj)[40], 1e-6)

    def test_the_next_free_name_is_taken(self):
        obj = posable()
        for name in ("ARAP", "ARAP.001", "ARAP.003"):
            own_key(obj, name)
        self.api.solve(obj)
        self.assertEqual(key_names(obj)[-1], "ARAP.002")
        long = "x" * 63
        own_key(obj, long)
        obj.arap.key_name = long + "yz"
        self.api.solve(obj)
        self.assertEqual((key_names(obj)[-1], obj.arap.key_name), ("x" * 57 + ".001",) * 2)

    def test_keys_made_before_are_continued(self):

        obj = posable()
        for name in ("ARAP", "Bent", "ARAP", "Bent"):
            obj.arap.key_name = name
            self.api.solve(obj)
            obj.data.shape_keys.key_blocks[name].value = 0.0
        self.assertEqual(key_names(obj), ["Basis", "ARAP", "Bent"])
        obj = opened_again()
        copy = copied(obj)
        self.api.copy_handles(copy)
        for item in (obj, copy):
            self.api.solve(item)
            self.assertEqual(key_names(item), ["Basis", "ARAP", "Bent"])

    def test_the_state_before_gives_the_name_back(self):
        obj = posable()
        own_key(obj, "ARAP", value=0.5)
        mine = key_positions(obj)
        state = module("pose.result").capture_state(obj)
        self.api.solve(obj)
        module("pose.result").restore_state(obj, state)
        self.assertEqual((key_names(obj), obj.arap.key_name), (["Basis", "ARAP"], ""))
        self.assert_close(key_positions(obj), mine, 0.0)
        self.api.solve(obj)
        self.assertEqual(key_names(obj), ["Basis", "ARAP", "ARAP.001"])

    def test_a_name_of_a_key_that_was_removed_is_free_again(self):
        obj = posable()
        self.api.solve(obj)
        obj.shape_key_remove(obj.data.shape_keys.key_blocks["ARAP"])
        module("scene.pose_key").forget_removed(obj)
        own_key(obj, "ARAP")
        self.api.solve(obj)
        self.assertEqual(key_names(obj), ["Basis", "ARAP", "ARAP.001"])

    def test_a_bake_keeps_the_name_that_it_has_taken_from_the_preferences(self):
        obj = posable()
        names = self.api.bake_animation(obj, 1, 2)
        values = bpy.context.preferences.addons[support.PACKAGE].preferences
        self.addCleanup(setattr, values, "key_name", values.key_name)
        values.key_name = "Posed"
        self.assertEqual(self.api.bake_animation(obj, 1, 2), names)
