# SPDX-License-Identifier: GPL-3.0-or-later
"""Which mesh operators and panels work on, and why an operator is grey."""

from unittest import mock

from support import FakeLock, SceneTest, bpy, linked_back, module
from tubes import BOTTOM, empty_at, mesh_object, posable

OPERATORS = sorted(name for name in dir(bpy.ops.arap) if not name.startswith("_"))


class ClaimTest(SceneTest):
    def claim(self, name, act):
        sessions = module("core.sessions")
        obj = bpy.data.objects[name, None]
        sessions.lock(obj, act)
        self.addCleanup(sessions.unlock, obj.session_uid, act)


class ManyHandlesTest(SceneTest):
    def test_which_mesh_an_empty_moves_is_found_once_until_something_changes(self):
        """Some sixty polls ask at each redraw, and a mesh may have thousands of handles."""
        obj = posable()
        head, other = obj.arap.handles[0].target, empty_at((0.0, 0.0, 4.0))
        ui_cache = module("scene.ui_cache")
        self.assertTrue(ui_cache.is_moved_by(obj, head))
        known = next(iter(ui_cache._targets.values()))
        known.clear()
        self.assertFalse(ui_cache.is_moved_by(obj, head), "no second look")
        obj.arap.handles[0].target = other
        self.assertEqual([ui_cache.is_moved_by(obj, each) for each in (head, other)], [False, True])
        module("api").remove_control(obj, obj.arap.handles[0].name)
        self.assertFalse(ui_cache.is_moved_by(obj, other))


class ErrorTest(SceneTest):
    def test_too_little_memory_is_told_in_words(self):
        """Python's own MemoryError has no text."""
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        text = "There is not enough memory"
        blend, pull = module("poses.blend_operator"), module("pull.operators")
        mouse = mock.Mock(mouse_x=0, type="MOUSEMOVE")
        for made, act in (
            ("poses.blend_operator.BlendRun", lambda it: blend.ARAP_OT_poses_blend._begin(it, bpy.context, mouse)),
            ("pull.operators.PullRun", lambda it: pull.ARAP_OT_pull._begin_drag(it, bpy.context, mouse, (0, 0))),
        ):
            operator = mock.Mock(_grip=mock.Mock(uid=obj.session_uid))
            where, _, name = made.rpartition(".")
            with mock.patch.object(module(where), name, side_effect=MemoryError):
                self.assertEqual(act(operator), {"CANCELLED"})
            operator.report.assert_called_once_with({"ERROR"}, text)
        operator, bake = mock.Mock(), module("bake.operators")
        with mock.patch.object(bake, "draw_text_in_dialog") as draw_text:
            bake.FramesOperator.draw_size(operator, bpy.context, mock.Mock(side_effect=MemoryError), "INFO")
        draw_text.assert_called_once_with(bpy.context, operator.layout, text, "ERROR")
        run = mock.Mock(_uid=obj.session_uid, _tracker=None)
        run.restore_handles.side_effect = MemoryError
        self.assertEqual(module("poses.blend_run").BlendRun.restore(run), text)
        act = module("engine.interaction").Interaction(mock.Mock())
        act.fail(MemoryError())
        self.assertEqual(act.end.message, f"Posing has ended and everything is as before: {text}")


class ReasonTest(ClaimTest):
    def reason(self, name: str) -> str:
        """Why an operator is grey."""
        operator = getattr(bpy.ops.arap, name)
        self.assertFalse(operator.poll(), name)
        with self.assertRaises(RuntimeError) as caught:
            operator()
        return str(caught.exception).partition("failed, context is incorrect")[0].partition("poll() ")[2].strip()

    def test_each_operator_says_what_it_lacks(self):
        """In an empty scene; then with a mesh alone."""
        for name in OPERATORS:
            self.assertGreater(len(self.reason(name)), 10, name)
        bpy.context.view_layer.objects.active = mesh_object()
        for name, wanted in (
            ("solve", "Add a handle first: nothing moves the mesh yet"),
            ("bake_pose", "There is no pose yet: pull the mesh or move a handle first"),
            ("pin_add", "Select vertices in Edit Mode (Tab) to pin them"),
            (
                "handle_add",
                "Select vertices in Edit Mode (Tab), or empties or bones with the mesh",
            ),
            ("control_remove", "Add a pin or a handle first: nothing holds or moves the mesh yet"),
            ("reset", "There is no pose yet: pull the mesh or move a handle first"),
            ("stiffness_remove", "Add stiffness first: the list is empty"),
            ("select_free_parts", "Add a pin or a handle first: nothing holds the mesh yet"),
        ):
            self.assertIn(wanted, self.reason(name))

    def test_a_mesh_that_is_busy_is_left_alone(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        self.claim(obj.name, FakeLock("it is solved"))
        followed = ("control_remove", "pin_add", "stiffness_add", "reset", "poses_store")
        for name in ("solve", "bake_animation", "edit_mesh", "select_free_parts", *followed):
            self.assertIn("Wait for the mesh: it is solved", self.reason(name))
        self.doCleanups()
        self.claim(obj.name, module("engine.interaction").Interaction(None))
        for name in followed:
            self.assertTrue(getattr(bpy.ops.arap, name).poll(), f"{name}: posing follows")
        self.assertIn("End the pose first: Enter keeps it, Esc cancels it", self.reason("solve"))

    def test_what_changes_the_pose_waits_for_a_render(self):
        obj = posable()
        bpy.context.view_layer.objects.active = obj
        self.api.store_pose(obj, "Pose")
        self.api.solve(obj)
        acts = (
            "solve",
            "bake_animation",
            "export_mesh_cache",
            "poses_to_keys",
            "bake_pose",
            "poses_apply",
        )
        for name in acts:
            self.assertTrue(getattr(bpy.ops.arap, name).poll(), name)
        with mock.patch.object(module("ui.checks"), "is_rendering", return_value=True):
            for name in acts:
                self.assertIn("Wait until the render ends", self.reason(name))

    def test_an_act_of_a_deleted_mesh_does_not_hide_the_selected_one(self):
        obj, former = mesh_object(), mesh_object("Former")
        bpy.context.view_layer.objects.active = None
        obj.select_set(True)
        self.claim("Former", FakeLock("it is solved"))
        bpy.data.objects.remove(former)
        self.assertEqual(module("ui.checks").find_arap_object(bpy.context), obj)

    def test_a_handle_that_is_a_mesh_shows_its_own_panel_unless_the_other_is_posed(self):
        obj, mover = posable(), mesh_object("Mover")
        obj.arap.handles[0].target = mover
        bpy.context.view_layer.objects.active = mover
        find = module("ui.checks").find_arap_object
        self.assertEqual(find(bpy.context), mover)
        self.claim(obj.name, FakeLock("it is posed"))
        self.assertEqual(find(bpy.context), obj)
        self.api.add_pin(mover, BOTTOM)
        self.assertEqual(find(bpy.context), mover)


class LinkedTwinTest(ClaimTest):
    """A linked object that has the name of a local one is another object."""

    def setUp(self):
        super().setUp()
        other = mesh_object()
        other.scale = (5.0, 5.0, 5.0)
        self.api.add_pin(other, BOTTOM, name="Feet")
        other.vertex_groups["Feet"].remove(BOTTOM)
        bpy.context.view_layer.update()
        (self.linked,) = linked_back(other, "Tube")
        bpy.context.scene.collection.objects.link(self.linked)
        self.obj = posable()
        self.assertEqual((self.obj.name, self.linked.name), ("Tube", "Tube"))

    def test_what_is_remembered_of_one_is_not_told_of_the_other(self):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        size, is_empty = module("scene.ui_cache").diagonal, module("scene.ui_cache").is_empty_group
        seen = module("pull.evaluated_mesh").read
        for obj in (self.obj, self.linked):  # the first is remembered where the second is asked for
            size(obj, depsgraph), is_empty(obj, "Feet"), seen(obj, depsgraph)
        self.assertFalse(is_empty(self.obj, "Feet"))
        self.assertTrue(is_empty(self.linked, "Feet"))
        self.assert_close(seen(self.linked, depsgraph).positions, 5.0 * seen(self.obj, depsgraph).positions, 1e-5)
        self.obj.data.update_tag()
        self.obj.update_tag()
        bpy.context.view_layer.update()
        known = module("scene.ui_cache")._sizes
        self.assertEqual((self.obj.session_uid in known, self.linked.session_uid in known), (False, True))

    def test_an_act_and_a_readout_are_of_the_local_one(self):
        self.api.solve(self.obj)
        self.assertIsNotNone(module("core.sessions").stats(self.obj.session_uid))
        self.assertIsNone(module("core.sessions").stats(self.linked.session_uid))
        self.claim("Tube", FakeLock("it is solved"))
        common = module("ui.checks")
        self.assertEqual(common.why_busy(self.linked), "")
        self.assertEqual(common.why_busy(self.obj), "Wait for the mesh: it is solved")
        self.assertFalse(module("ui.panels").is_following(self.linked))
        bpy.context.view_layer.objects.active = None
        self.assertEqual(common.find_arap_object(bpy.context), self.obj)
