# SPDX-License-Identifier: GPL-3.0-or-later
"""The add-on's preferences."""

from looks import key_names
from support import SceneTest, bpy, module
from tubes import mesh_object, move, posable


class PreferencesTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.preferences = module("props.preferences")
        self.values = bpy.context.preferences.addons[self.preferences.ADDON].preferences
        for name in type(self.values).__annotations__:
            if name != "pull":
                self.addCleanup(setattr, self.values, name, getattr(self.values, name))

    def test_the_session_has_the_threads_and_another_number_binds_again(self):
        obj = posable()
        self.values.threads = 2
        first = module("engine.update").prepare_session(obj)
        self.assertEqual(first.settings.threads, 2)
        self.assertIs(module("engine.update").prepare_session(obj), first)
        self.values.threads = 1
        second = module("engine.update").prepare_session(obj)
        self.assertEqual((second.settings.threads, second is first), (1, False))

    def test_the_name_of_the_key_is_for_meshes_without_a_name_of_their_own(self):
        self.values.key_name = "Posed"
        obj, own = posable(), posable("Own")
        own.arap.key_name = "Mine"
        self.api.solve(obj)
        self.api.solve(own)
        self.assertEqual(key_names(obj), ["Basis", "Posed"])
        self.assertEqual([key.name for key in own.data.shape_keys.key_blocks], ["Basis", "Mine"])
        self.values.key_name = "Later"
        move(obj.arap.handles[0].target, (0.3, 0.0, 0.0))
        self.api.solve(obj)
        self.assertEqual(obj.arap.key_name, "Posed", "the pose stays in its key")
        self.assertEqual(len(obj.data.shape_keys.key_blocks), 2)
        for name, wanted in (("Later", "Later"), ("", "ARAP")):
            self.values.key_name = name
            self.assertEqual(module("scene.pose_key").name_of(mesh_object()), wanted)

    def test_blender_saves_changed_settings_of_pull_when_it_ends(self):
        pull, preferences = self.preferences.pull(), bpy.context.preferences
        for name, value in (("radius", 55), ("use_auto_reach", False), ("reach", 2.0), ("use_turn", False)):
            self.addCleanup(setattr, pull, name, getattr(pull, name))
            preferences.is_dirty = False
            setattr(pull, name, value)
            self.assertTrue(preferences.is_dirty)
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        self.assertEqual(self.preferences.pull().radius, 55, "another file")

    def test_what_is_drawn_has_colors_of_the_theme(self):
        batches, theme = module("ui.batches"), bpy.context.preferences.themes[0]
        for color, wanted in (
            (batches.color_of_pins(), theme.view_3d.bone_pose),
            (batches.color_of_handles(), theme.view_3d.vertex_select),
            (batches.color_of_pull(), theme.user_interface.gizmo_primary),
        ):
            self.assert_close(color, (*wanted[:3], 1.0))

    def test_without_preferences_there_are_defaults(self):
        self.values.refine_time = 0.2
        self.assert_close(self.preferences.refine_time_s(), 0.2)
        self.addCleanup(setattr, self.preferences, "ADDON", self.preferences.ADDON)
        self.preferences.ADDON = "not_there"
        self.assertEqual((self.preferences.threads(), self.preferences.key_name()), (0, "ARAP"))
        self.assertEqual(self.preferences.refine_time_s(), 0.05)
