# SPDX-License-Identifier: GPL-3.0-or-later
"""The five steps of First Pose."""

from support import SceneTest, bpy, module
from tubes import BOTTOM, TOP, mesh_object, posable, select_in_edit_mode


class FirstPoseTest(SceneTest):
    def setUp(self) -> None:
        super().setUp()
        self.first_pose = module("tab.first_pose")

    def active_mesh(self, *, is_ready=False):
        obj = posable() if is_ready else mesh_object()
        bpy.context.view_layer.objects.active = obj
        return obj

    def state(self, obj) -> tuple[int, str]:
        """The number of done steps, which are the first ones, and the operator of the next step."""
        steps = self.first_pose.steps(obj)
        n_done = [step.is_done for step in steps].index(False)
        self.assertEqual([step.is_done for step in steps], [True] * n_done + [False] * (5 - n_done))
        return n_done, steps[n_done].operator

    def why_not(self, step) -> str:
        return self.first_pose.why_not(bpy.context, step)

    def test_five_steps_are_done_one_after_the_other_by_their_buttons(self):
        self.assertEqual(self.state(None), (0, ""))
        obj = self.active_mesh()
        self.assertEqual(self.state(obj), (1, "arap.edit_mesh"))
        bpy.ops.arap.edit_mesh()
        self.assertEqual(self.state(obj), (2, "arap.pin_add"))
        select_in_edit_mode(obj, BOTTOM)
        bpy.ops.arap.pin_add()
        self.assertEqual(self.state(obj), (3, "arap.handle_add"))
        select_in_edit_mode(obj, TOP)
        bpy.ops.arap.handle_add()
        self.assertEqual(self.state(obj), (4, "arap.edit_mesh"))
        bpy.ops.arap.edit_mesh()
        self.assertEqual((self.state(obj), obj.mode), ((4, "arap.pose"), "OBJECT"))
        for step in self.first_pose.steps(obj):
            if step.operator.startswith("arap") and step.text != "Enter Edit Mode":
                rna = getattr(bpy.ops.arap, step.operator.removeprefix("arap.")).get_rna_type()
                self.assertEqual(step.text, rna.name, "the step and its operator have one name")
        self.assertTrue(self.first_pose.is_wanted(None) and self.first_pose.is_wanted(obj))
        self.api.solve(obj)
        self.assertFalse(self.first_pose.is_wanted(obj))

    def test_a_second_handle_holds_as_well_as_a_pin(self):
        obj = mesh_object()
        for vertices, is_held in ((TOP, False), (BOTTOM, True)):
            self.api.add_handle(obj, vertices)
            self.assertEqual(self.first_pose.steps(obj)[2].is_done, is_held)

    def test_a_whole_selection_is_not_to_be_pinned(self):
        obj = self.active_mesh()
        bpy.ops.arap.edit_mesh()
        for action, hint in (("SELECT", "All vertices are selected now"), ("DESELECT", "Select the vertices to hold")):
            bpy.ops.mesh.select_all(action=action)
            self.assertTrue(self.first_pose.steps(obj)[2].hint.startswith(hint))

    def test_the_last_step_leads_out_of_each_mode(self):
        obj = self.active_mesh(is_ready=True)
        for mode, operator, to_mode in (
            ("EDIT", "arap.edit_mesh", ""),
            ("WEIGHT_PAINT", "object.mode_set", "OBJECT"),
            ("SCULPT", "object.mode_set", "OBJECT"),
            ("OBJECT", "arap.pose", ""),
        ):
            bpy.ops.object.mode_set(mode=mode)
            step = self.first_pose.steps(obj)[-1]
            self.assertEqual((step.operator, step.mode, self.why_not(step)), (operator, to_mode, ""))

    def test_a_hint_gives_the_reason_why_its_button_is_grey(self):
        obj = self.active_mesh(is_ready=True)
        obj.arap.handles[0].is_enabled = False
        steps = self.first_pose.steps(obj)
        self.assertEqual(self.why_not(steps[-1]), "Add a handle first: nothing moves the mesh yet")
        for step in steps:
            if step.operator in self.first_pose.WHY_NOT and step.operator != "arap.pose":  # posing needs a window
                operator = getattr(bpy.ops.arap, step.operator.removeprefix("arap."))
                self.assertEqual(not self.why_not(step), operator.poll(), step.operator)

    def test_the_first_step_tells_how_to_select_a_mesh(self):
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        bpy.ops.object.armature_add()
        for mode, reason in (
            ("OBJECT", ""),
            ("EDIT", "Go to Object Mode first (Tab)"),
            ("POSE", "Go to Object Mode first, in the menu at the top left of the view"),
        ):
            bpy.ops.object.mode_set(mode=mode)
            self.assertEqual(self.why_not(self.first_pose.steps(None)[0]), reason)

    def test_while_posing_the_last_step_is_to_move_the_empty(self):
        obj = posable()
        posing = module("follow.act").PoseAct(None)
        module("core.sessions").claim(obj.name, posing)
        self.addCleanup(module("core.sessions").release, obj.name, posing)
        step = self.first_pose.steps(obj)[-1]
        self.assertEqual((step.text, step.operator, step.is_done), ("Move the empty", "", False))

    def test_the_button_edits_the_mesh_if_a_handle_is_active(self):
        obj = posable()
        target = obj.arap.handles[0].target
        target.select_set(True)
        bpy.context.view_layer.objects.active = target
        bpy.ops.arap.edit_mesh()
        self.assertEqual((bpy.context.object, obj.mode, target.select_get()), (obj, "EDIT", False))

    def test_a_hidden_mesh_cannot_be_edited(self):
        obj = self.active_mesh(is_ready=True)
        obj.hide_set(True)
        for name in ("edit_mesh", "group_select", "group_paint"):
            with self.assertRaisesRegex(RuntimeError, "'Tube' is hidden: show it first", msg=name):
                getattr(bpy.ops.arap, name)()
        self.assertEqual(obj.mode, "OBJECT")
