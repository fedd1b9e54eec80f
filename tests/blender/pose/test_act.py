# SPDX-License-Identifier: GPL-3.0-or-later
"""What a posing act sees of Blender: why it is over, and the key that it writes."""

from typing import Any
from unittest import mock

import bmesh
from looks import key_names, key_positions, unfit
from support import SceneTest, bpy, module
from tubes import bend, posable, solved


class PoseSceneTest(SceneTest):
    def act(self, obj: bpy.types.Object) -> Any:
        return module("pose.scene").BlenderPoseScene(obj)

    def test_what_ends_it(self):
        left = "'Tube' was deleted: posing has ended"
        for change, why in (
            (lambda obj: bpy.data.objects.remove(obj), left),  # noqa: PLW0108 - a new file has new data
            (lambda obj: setattr(obj, "name", "Pole"), ""),
            (
                lambda _obj: bpy.ops.object.mode_set(mode="EDIT"),
                "'Tube' is no longer in Object Mode: posing has ended",
            ),
            (lambda obj: obj.data.vertices.add(1), "The mesh of 'Tube' has changed: posing has ended"),
        ):
            with self.subTest(why=why):
                self.setUp()
                obj = posable()
                bpy.context.view_layer.objects.active = obj
                self.api.solve(obj)
                act = self.act(obj)
                self.assertEqual(act.look(), "")
                change(obj)
                self.assertEqual(act.look(), why)

    def test_keep_and_cancel_of_the_tab_end_it(self):
        obj = solved()
        bpy.context.view_layer.objects.active = obj
        sessions = module("core.sessions")
        for is_kept in (True, False):
            act = module("engine.interaction").Interaction(mock.Mock())
            sessions.lock(obj, act)
            self.addCleanup(sessions.unlock, obj.session_uid, act)
            self.assertEqual(bpy.ops.arap.pose_end(is_kept=is_kept), {"FINISHED"})
            self.assertIsNotNone(act.end)
            sessions.unlock(obj.session_uid, act)

    def test_a_lost_handle_has_no_motion(self):
        obj = solved()
        act = self.act(obj)
        obj.vertex_groups["Head"].name = "Top"
        message = "Handle 'Head' of 'Tube': there is no vertex group 'Head'; choose one or remove the handle"
        act.look()
        self.assert_error(ValueError, message, act.matrices)

    def test_vertices_in_another_order_are_not_bound_again(self):
        obj = posable()
        module("engine.update").prepare_session(obj)
        act = self.act(obj)
        mesh = bmesh.new()
        mesh.from_mesh(obj.data)
        mesh.verts.sort(reverse=True)
        mesh.to_mesh(obj.data)
        mesh.free()
        bpy.context.view_layer.update()
        act.look()
        self.assertFalse(act.is_bound())
        self.assert_error(ValueError, "The faces of 'Tube' have changed", act.begin_bind)

    def test_another_key_ends_a_session_and_the_act_before_it_is_written(self):
        obj = solved()
        act = self.act(obj)
        self.assertEqual(act.look(), "")
        obj.arap.key_name = "Bent"
        changed = "The pose of 'Tube' has another shape key now"
        self.assertEqual(act.look(), f"{changed}, and is kept in 'ARAP': posing has ended")
        self.assertEqual(unfit(obj, is_thorough=True), changed)
        self.assert_error(RuntimeError, f"{changed}: start posing again", module("engine.update").update_pose, obj)
        self.assertEqual(key_names(obj), ["Basis", "ARAP"])
        module("engine.update").prepare_session(obj)
        self.assertEqual(unfit(obj, is_thorough=True), "")

    def test_a_renamed_key_is_followed_and_a_removed_one_ends_the_act(self):
        obj = posable()
        act = self.act(obj)
        module("engine.update").prepare_session(obj)
        for name in ("ARAP", "Bent", "Bowed"):
            if obj.data.shape_keys is not None:
                obj.data.shape_keys.key_blocks[obj.arap.key_name].name = name
            self.assertEqual(act.look(), "")
            bend(obj)
            act.look()
            self.assertTrue(act.is_bound())
            act.update(act.matrices(), None, 1.0)
            self.assertEqual(key_names(obj), ["Basis", name])
            self.assertEqual(obj.arap.key_name, name)
            self.assertEqual(unfit(obj, is_thorough=True), "")
        obj.shape_key_remove(obj.data.shape_keys.key_blocks["Bowed"])
        self.assertEqual(act.look(), "Shape key 'Bowed' of 'Tube' was removed: posing has ended")

    def test_an_end_that_restores_gives_the_key_its_name_back(self):
        obj = posable()
        self.api.solve(obj)
        before = key_positions(obj)
        act = self.act(obj)
        module("engine.update").prepare_session(obj)
        self.assertEqual(act.look(), "")
        obj.data.shape_keys.key_blocks["ARAP"].name = "Bent"
        self.assertEqual(act.look(), "")
        bend(obj)
        act.look()
        self.assertTrue(act.is_bound())
        act.update(act.matrices(), None, 1.0)
        act.restore(obj)
        self.assertEqual(key_names(obj), ["Basis", "ARAP"])
        self.assertEqual((obj.arap.key_name, [key.name for key in obj.arap.made_keys]), ("ARAP", ["ARAP"]))
        self.assert_close(key_positions(obj), before, 0.0)
